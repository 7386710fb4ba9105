#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cloister::testing {

using Bytes = std::vector<std::byte>;

/// Appends numbers to bytes, in either order.
inline void put_le(Bytes& out, std::uint64_t value, int num_bytes) {
  for (int i = 0; i < num_bytes; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i)));
}
inline void put_be(Bytes& out, std::uint64_t value, int num_bytes) {
  for (int i = num_bytes - 1; i >= 0; --i) out.push_back(static_cast<std::byte>(value >> (8 * i)));
}
inline void put(Bytes& out, std::span<const std::byte> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

/// A UDP segment: ports, length, no checksum, payload.
inline Bytes udp_segment(std::span<const std::byte> payload, int destination_port = 7502) {
  Bytes out;
  put_be(out, 50000, 2);
  put_be(out, static_cast<std::uint64_t>(destination_port), 2);
  put_be(out, payload.size() + 8, 2);
  put_be(out, 0, 2);
  put(out, payload);
  return out;
}

/// What an IPv4 header says, beside its payload.
struct Ipv4Options {
  std::uint32_t source = 0xc0a80002;
  int id = 1;
  int offset_bytes = 0;
  bool more = false;
  int protocol = 17;
  int total_length = -1;  ///< -1: the true one
  int header_words = 5;
};

inline Bytes ipv4_packet(std::span<const std::byte> payload, const Ipv4Options& options = {}) {
  Bytes out;
  put_be(out, static_cast<std::uint64_t>(0x40 | options.header_words), 1);
  put_be(out, 0, 1);
  put_be(out,
         options.total_length >= 0 ? static_cast<std::uint64_t>(options.total_length)
                                   : payload.size() + 20,
         2);
  put_be(out, static_cast<std::uint64_t>(options.id), 2);
  put_be(out, static_cast<std::uint64_t>(options.offset_bytes / 8 | (options.more ? 0x2000 : 0)),
         2);
  put_be(out, 64, 1);
  put_be(out, static_cast<std::uint64_t>(options.protocol), 1);
  put_be(out, 0, 2);
  put_be(out, options.source, 4);
  put_be(out, 0xc0a80001, 4);
  put(out, payload);
  return out;
}

/// Link-layer headers in front of a packet.
inline Bytes ethernet(std::span<const std::byte> packet, int ethertype = 0x0800,
                      const std::vector<int>& vlan_types = {}) {
  Bytes out(12);
  for (const int type : vlan_types) {
    put_be(out, static_cast<std::uint64_t>(type), 2);
    put_be(out, 42, 2);
  }
  put_be(out, static_cast<std::uint64_t>(ethertype), 2);
  put(out, packet);
  return out;
}
inline Bytes linux_cooked(std::span<const std::byte> packet) {
  Bytes out(14);
  put_be(out, 0x0800, 2);
  put(out, packet);
  return out;
}
inline Bytes linux_cooked_2(std::span<const std::byte> packet) {
  Bytes out;
  put_be(out, 0x0800, 2);
  out.resize(20);
  put(out, packet);
  return out;
}
inline Bytes loopback(std::span<const std::byte> packet, std::uint32_t family = 2) {
  Bytes out;
  put_le(out, family, 4);
  put(out, packet);
  return out;
}

/// A classic pcap file in memory; link types are those of the file format (Ethernet 1, raw IP 101).
class PcapBuilder {
 public:
  explicit PcapBuilder(std::uint32_t link_type = 1) {
    put_le(bytes_, 0xa1b2c3d4, 4);
    put_le(bytes_, 2, 2);
    put_le(bytes_, 4, 2);
    put_le(bytes_, 0, 8);
    put_le(bytes_, 262144, 4);
    put_le(bytes_, link_type, 4);
  }
  void add(std::span<const std::byte> record, std::int64_t time_us = 0, int missing_bytes = 0) {
    put_le(bytes_, static_cast<std::uint64_t>(time_us / 1'000'000), 4);
    put_le(bytes_, static_cast<std::uint64_t>(time_us % 1'000'000), 4);
    put_le(bytes_, record.size(), 4);
    put_le(bytes_, record.size() + static_cast<std::size_t>(missing_bytes), 4);
    put(bytes_, record);
  }
  /// A datagram cut into fragments that carry `fragment_bytes` each, over Ethernet.
  void add_fragmented(std::span<const std::byte> segment, int id, std::int64_t time_us = 0,
                      int fragment_bytes = 1480) {
    const int size = static_cast<int>(segment.size());
    for (int at = 0; at < size; at += fragment_bytes) {
      const int end = at + fragment_bytes < size ? at + fragment_bytes : size;
      add(ethernet(ipv4_packet(
              segment.subspan(static_cast<std::size_t>(at), static_cast<std::size_t>(end - at)),
              {.id = id, .offset_bytes = at, .more = end < size})),
          time_us);
    }
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

}  // namespace cloister::testing
