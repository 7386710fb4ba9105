#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/core/time.hpp"

namespace cloister {

/// Who talks to whom in the capture.
struct UdpFlow {
  std::uint32_t source_ip = 0xC0A80A7B;       ///< 192.168.10.123
  std::uint32_t destination_ip = 0xC0A80A01;  ///< 192.168.10.1
  std::uint16_t source_port = 7502;
  std::uint16_t destination_port = 7502;
};

/// The 24-byte header of a classic little-endian pcap file with microsecond stamps and Ethernet
/// frames.
void append_pcap_header(std::vector<std::uint8_t>* out);

/// Appends the records of one UDP datagram as a capture on Ethernet holds them: IPv4 fragments of
/// at most 1,500 bytes, each in a frame of its own, all with the stamp of the arrival.
/// @param ip_id identification field, the same in every fragment; the caller counts it up
void append_udp_datagram(const UdpFlow& flow, SensorTime stamp, std::uint16_t ip_id,
                         std::span<const std::uint8_t> payload, std::vector<std::uint8_t>* out);

/// The internet checksum (RFC 1071) of bytes, continued from a partial sum.
[[nodiscard]] std::uint32_t add_to_checksum(std::span<const std::uint8_t> bytes, std::uint32_t sum);
[[nodiscard]] std::uint16_t finish_checksum(std::uint32_t sum);

}  // namespace cloister
