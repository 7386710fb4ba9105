#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace cloister {

/// One UDP datagram over IPv4, as it arrived. Addresses and ports are in host byte order.
struct UdpDatagram {
  std::uint32_t source_address = 0;
  std::uint16_t source_port = 0;
  std::uint16_t destination_port = 0;
  std::int64_t capture_time_ns = 0;    ///< when the host received it, host clock (Unix time)
  std::span<const std::byte> payload;  ///< valid until its source is asked for the next datagram
};

}  // namespace cloister
