#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "firmware_interface/ouster/counters.hpp"
#include "firmware_interface/ouster/udp_datagram.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// What a socket has received.
enum class SocketCause {
  kDatagrams,
  kKernelDrops,
  kOversized,
  kReceiveErrors,
  kCount,
};

constexpr std::array<CounterName, 4> counter_names(SocketCause) {
  return {{{"socket_datagrams"},
           {"socket_kernel_drops", true},  // the receive buffer was full
           {"socket_oversized", true},     // longer than any lidar packet
           {"socket_receive_errors", true}}};
}

/// Receives a sensor's datagrams over IPv4, many a system call. The kernel keeps what arrives between two calls in the
/// receive buffer and counts what does not fit.
///
/// Threads: one at a time. Real-time: no allocation after it has been opened; never waits.
class UdpSource {
 public:
  struct Options {
    std::uint16_t port = 7502;            ///< 0: any free one, see `port()`
    std::string address;                  ///< of the interface to listen on; empty: all of them
    int receive_buffer_bytes = 16 << 20;  ///< two seconds of an OS1-64 at 10 Hz
  };

  /// Fails with kResource, naming the port, when it is taken or not permitted.
  [[nodiscard]] static Result<UdpSource> open(const Options& options);

  UdpSource(UdpSource&& other) noexcept;
  UdpSource& operator=(UdpSource&& other) noexcept;
  ~UdpSource();

  /// The next datagram that has arrived; its payload is valid until the next call.
  /// @return false when none is waiting
  bool next(UdpDatagram& datagram);

  /// Readable when `next` has something to look at, for poll(2).
  [[nodiscard]] int file_descriptor() const { return fd_; }
  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// What the kernel granted, in its own way of counting: bookkeeping included.
  [[nodiscard]] int receive_buffer_bytes() const { return granted_bytes_; }
  [[nodiscard]] const Counters<SocketCause>& counters() const { return counters_; }

 private:
  struct Batch;

  UdpSource() = default;
  bool refill();

  int fd_ = -1;
  std::uint16_t port_ = 0;
  int granted_bytes_ = 0;
  std::unique_ptr<Batch> batch_;
  std::uint32_t drops_seen_ = 0;  ///< the kernel's own counter, which wraps around
  Counters<SocketCause> counters_;
};

/// Sends datagrams to one address, for playing recorded packets.
class UdpSender {
 public:
  /// @param host  an IPv4 address or a name
  /// @return kInput when the host is not known, kResource when no socket can be had
  [[nodiscard]] static Result<UdpSender> open(const std::string& host, std::uint16_t port);

  UdpSender(UdpSender&& other) noexcept;
  UdpSender& operator=(UdpSender&& other) noexcept;
  ~UdpSender();

  /// @return false when the network did not take it
  bool send(std::span<const std::byte> payload);

 private:
  UdpSender() = default;

  int fd_ = -1;
};

}  // namespace cloister
