#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "firmware_interface/ouster/counters.hpp"
#include "firmware_interface/ouster/ipv4_reassembler.hpp"
#include "firmware_interface/ouster/udp_datagram.hpp"
#include "mapping/core/result.hpp"

struct pcap;  // libpcap's handle; its header stays in the source file

namespace cloister {

/// What a capture is made of.
enum class CaptureCause {
  kRecords,
  kDatagrams,
  kNotIp,
  kIpv6,
  kNotUdp,
  kCutRecord,
  kMalformedHeader,
  kMalformedFragment,
  kRepeatedFragment,
  kIncompleteDatagram,
  kCount,
};

constexpr std::array<CounterName, 10> counter_names(CaptureCause) {
  return {{{"capture_records"},
           {"capture_datagrams"},
           {"capture_not_ip", true},
           {"capture_ipv6", true},
           {"capture_not_udp", true},
           {"capture_cut_record", true},        // shorter in the file than it was on the wire
           {"capture_malformed_header", true},  // an IPv4 or UDP header that contradicts itself
           {"capture_malformed_fragment", true},
           {"capture_repeated_fragment"},
           {"capture_incomplete_datagram", true}}};
}

/// Reads the UDP datagrams of a packet capture: pcap and pcapng; Ethernet (with VLAN tags), Linux
/// cooked v1 and v2, loopback and raw IP; IPv4, whole or fragmented. Anything else is skipped and
/// counted.
///
/// Threads: one at a time. Real-time: no allocation of its own after it has been opened.
class PcapSource {
 public:
  /// Fails with kInput, naming the file, when it is missing, empty, not a capture,
  /// or of a link type not listed above.
  [[nodiscard]] static Result<PcapSource> open(const std::filesystem::path& path);
  /// Reads a capture that lies in memory; `bytes` must outlive the source.
  /// `name` stands for the path in messages.
  [[nodiscard]] static Result<PcapSource> from_memory(std::span<const std::byte> bytes,
                                                      std::string name);

  /// Finds the next datagram; its payload is valid until the next call.
  /// @return true, or false at the end of the capture; kInput, with the byte, where the file is
  ///         corrupt. A file that stops inside its last record ends there, and `warning()` tells.
  [[nodiscard]] Result<bool> next(UdpDatagram& datagram);

  /// One line about a capture that was cut off, once its end has been reached.
  [[nodiscard]] std::optional<std::string> warning() const;
  [[nodiscard]] const Counters<CaptureCause>& counters() const { return counters_; }

 private:
  struct Closer {
    void operator()(pcap* handle) const;
  };

  PcapSource(std::unique_ptr<pcap, Closer> handle, int link_type, std::string name);
  static Result<PcapSource> from_file(std::FILE* file, std::string name);

  bool parse_record(std::span<const std::byte> record, std::int64_t capture_time_ns,
                    UdpDatagram& datagram);
  bool parse_ipv4(std::span<const std::byte> packet, std::int64_t capture_time_ns,
                  UdpDatagram& datagram);
  bool parse_udp(std::span<const std::byte> segment, UdpDatagram& datagram);
  void finish();

  std::unique_ptr<pcap, Closer> handle_;
  int link_type_;
  std::string name_;
  std::unique_ptr<Ipv4Reassembler> reassembler_;
  Counters<CaptureCause> counters_;
  bool ended_ = false;
  std::optional<std::int64_t> cut_at_byte_;
};

}  // namespace cloister
