#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cloister {

/// One fragment of an IPv4 datagram that carries UDP.
struct Ipv4Fragment {
  std::uint32_t source_address = 0;
  std::uint32_t destination_address = 0;
  std::uint16_t id = 0;
  int offset = 0;  ///< bytes, a multiple of 8
  bool more = false;
  std::int64_t capture_time_ns = 0;
  std::span<const std::byte> payload;
};

/// Puts fragmented datagrams together (RFC 791), within fixed bounds.
///
/// Memory: `kMaxDatagrams` buffers of 64 KiB, taken at construction; when all are in use, the one
/// begun first is given up.
///
/// Age: fragments more than `kMaxAgeNs` apart do not belong together, since ids come round within a
/// minute.
///
/// Repeats: a fragment that repeats one that is held replaces it. A first fragment that differs
/// from the one held, or any that contradicts what is held (partial overlap, another end), begins
/// the datagram anew: its id has been used again, what was held is a stray.
///
/// Every datagram given up is counted.
///
/// Threads: one at a time. Real-time: no allocation after construction.
class Ipv4Reassembler {
 public:
  static constexpr int kMaxDatagrams = 16;
  static constexpr std::int64_t kMaxAgeNs = 2'000'000'000;
  static constexpr int kMaxBytes = 65535;

  Ipv4Reassembler();

  /// Takes one fragment; returns the whole datagram's payload once this one completes it, else an
  /// empty span. The payload stays valid until the next call.
  [[nodiscard]] std::span<const std::byte> add(const Ipv4Fragment& fragment);

  /// Gives up everything that is still incomplete.
  void clear();

  [[nodiscard]] std::uint64_t malformed_fragments() const { return malformed_fragments_; }
  [[nodiscard]] std::uint64_t repeated_fragments() const { return repeated_fragments_; }
  [[nodiscard]] std::uint64_t incomplete_datagrams() const { return incomplete_datagrams_; }

 private:
  static constexpr int kUnitBytes = 8;

  struct Slot {
    bool in_use = false;
    std::uint32_t source_address = 0;
    std::uint32_t destination_address = 0;
    std::uint16_t id = 0;
    std::int64_t begun_ns = 0;
    std::uint64_t order = 0;  ///< when it was begun, counted in datagrams
    int total_bytes = 0;      ///< 0 until the last fragment is here
    int held_bytes = 0;
    int end_bytes = 0;  ///< end of the furthest fragment held
    std::bitset<kMaxBytes / kUnitBytes + 1> held_units;
    std::vector<std::byte> bytes;
  };

  Slot& slot_for(const Ipv4Fragment& fragment);
  void begin(Slot& slot, const Ipv4Fragment& fragment);
  void give_up(Slot& slot);

  std::array<Slot, kMaxDatagrams> slots_;
  std::uint64_t order_ = 0;
  std::uint64_t malformed_fragments_ = 0;
  std::uint64_t repeated_fragments_ = 0;
  std::uint64_t incomplete_datagrams_ = 0;
};

}  // namespace cloister
