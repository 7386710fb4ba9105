#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace cloister {

/// How a counter is called outside, and whether what it counts was dropped.
struct CounterName {
  std::string_view name;
  bool is_drop = false;
};

/// One counter per enumerator of `Cause`, which ends in `kCount` and has a table of names found by
/// argument-dependent lookup: `constexpr std::array<CounterName, N> counter_names(Cause)`. Threads:
/// none of its own; whoever counts owns it. Counting does not allocate, the maps do.
template <typename Cause>
class Counters {
 public:
  void add(Cause cause, std::uint64_t count = 1) {
    counts_[static_cast<std::size_t>(cause)] += count;
  }
  [[nodiscard]] std::uint64_t operator[](Cause cause) const {
    return counts_[static_cast<std::size_t>(cause)];
  }

  /// Every counter by name, zeros included.
  [[nodiscard]] std::map<std::string, std::uint64_t> all() const { return collect(false); }
  /// Every counter of a drop that is not zero, by name.
  [[nodiscard]] std::map<std::string, std::uint64_t> drops() const { return collect(true); }

 private:
  static constexpr auto kNames = counter_names(Cause{});
  static_assert(kNames.size() == static_cast<std::size_t>(Cause::kCount));

  std::map<std::string, std::uint64_t> collect(bool drops_only) const {
    std::map<std::string, std::uint64_t> named;
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      if (drops_only && (!kNames[i].is_drop || counts_[i] == 0)) continue;
      named.emplace(kNames[i].name, counts_[i]);
    }
    return named;
  }

  std::array<std::uint64_t, static_cast<std::size_t>(Cause::kCount)> counts_{};
};

}  // namespace cloister
