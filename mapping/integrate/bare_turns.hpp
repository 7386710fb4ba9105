#pragma once

#include <algorithm>
#include <cstddef>

namespace cloister {

/// How often the bare blocks of far chunks are asked which of their octants are seen through. They hold nothing that could
/// be cleared, and nine in ten show nothing: they lie in the shade of leaves, or behind a wall with a window. Beside trees
/// there are so many of them that asking each takes most of a scan's time; indoors it is a sixth. So they are asked half
/// as often as all the rest, and where there are many, a third as often.
///
/// The turns of a scan follow from what the one before has asked, a number of blocks and never a clock: every machine
/// makes the same map.
class BareTurns {
 public:
  static constexpr int kMinTurns = 2, kMaxTurns = 3;

  /// Bare blocks are asked by one in so many of the scans that ask their chunk.
  [[nodiscard]] int turns() const { return turns_; }

  /// Chooses the turns of the next scan. @param num_near  bare blocks that the last one asked whatever the turns
  /// @param num_far  those that it asked because it was their turn
  void choose(std::size_t num_near, std::size_t num_far) {
    const std::size_t room = std::max(kMaxAsked - std::min(num_near, kMaxAsked), kMinFar);
    const std::size_t all_far = num_far * static_cast<std::size_t>(turns_);
    const auto turns_for = [&](std::size_t blocks) {
      return static_cast<int>(
          std::clamp<std::size_t>((blocks + room - 1) / room, kMinTurns, kMaxTurns));
    };
    // Fewer only with room to spare: between two numbers that come and go, some blocks would be asked rarely.
    turns_ = std::max(turns_for(all_far), std::min(turns_, turns_for(all_far + all_far / 4)));
  }

 private:
  // Bare blocks that a scan is meant to ask: about 8 ms of one core.
  static constexpr std::size_t kMaxAsked = 28'000;
  // What is left for far ones, however many are near.
  static constexpr std::size_t kMinFar = kMaxAsked / 4;

  int turns_ = kMinTurns;
};

}  // namespace cloister
