#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "mapping/graph/pose_graph.hpp"

namespace cloister {

/// Sparse Cholesky factorisation P A P^T = L L^T of a symmetric positive definite matrix of 6x6
/// blocks.
///
/// A general sparse solver sees single numbers; here every index, and every step of the elimination
/// tree, moves 36 of them at once. The ordering P is approximate minimum degree on the graph of
/// blocks. Terms as in T. Davis, "Direct Methods for Sparse Linear Systems" (2006), chapters 4 and
/// 7; the numeric phase is right-looking, in place.
///
/// Blocks are numbered as the caller numbers them; the permutation stays inside.
/// Threads: one at a time.
class BlockCholesky {
 public:
  /// A block's row and column in A; which of the two is larger does not matter.
  using Position = std::pair<int, int>;

  /// Fixes the structure and sets A to zero. O(blocks of L). Allocates L.
  /// @param off_diagonal  where A is not zero besides its diagonal: row and column differ, both in
  ///                      [0, num_blocks); positions may repeat
  BlockCholesky(int num_blocks, std::span<const Position> off_diagonal);

  /// A(block, block) += value (symmetric).
  void add_diagonal(int block, const Matrix6d& value);

  /// A(row, col) += value, A(col, row) += value^T. The position must have been named at
  /// construction.
  void add_off_diagonal(int row, int col, const Matrix6d& value);

  /// Replaces A by its factor. A pivot below 1e-12 of the diagonal entry it came from counts as
  /// zero: A is singular (to working precision), indefinite or not finite.
  /// @return nothing on success, else the block at which it stopped; the object is useless then
  [[nodiscard]] std::optional<int> factor();

  /// The rows of L^-1 P E_block that are not zero, E_block being the six unit columns of a block:
  /// they lie on the path from the block to the root of its elimination tree.
  struct Column {
    std::vector<int> rows;         ///< ascending, in the order of elimination
    std::vector<Matrix6d> blocks;  ///< one per row
  };

  /// One sparse forward solve with six right-hand sides. Needs a factor. Allocates.
  [[nodiscard]] Column solve_unit(int block) const;

  [[nodiscard]] int num_blocks() const { return static_cast<int>(parent_.size()); }
  /// Blocks of L, the diagonal included.
  [[nodiscard]] std::size_t num_factor_blocks() const { return rows_.size(); }

 private:
  [[nodiscard]] std::size_t find(int row, int col) const;

  std::vector<int> order_;          ///< caller's block -> place in the order of elimination
  std::vector<int> parent_;         ///< elimination tree, -1 at a root
  std::vector<std::size_t> begin_;  ///< first block of each column of L; one more for the end
  std::vector<int> rows_;           ///< of L by column, ascending; the diagonal block comes first
  std::vector<Matrix6d> values_;    ///< A, then L, at rows_
};

}  // namespace cloister
