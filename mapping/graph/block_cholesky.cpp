#include "mapping/graph/block_cholesky.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

namespace cloister {
namespace {

/// A pivot that shrank below this share of its diagonal entry of A has lost all but its last
/// digits: what is left is mostly rounding error. Singular graphs leave 1e-14 here, the worst
/// scaled of the public ones 1e-6.
constexpr double kMinPivotRatio = 1e-12;

/// Place of each block in an approximate minimum degree ordering.
std::vector<int> minimum_degree(int num_blocks,
                                std::span<const BlockCholesky::Position> off_diagonal) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(2 * off_diagonal.size() + num_blocks);
  for (const auto& [row, col] : off_diagonal) {
    entries.emplace_back(row, col, 1.0);
    entries.emplace_back(col, row, 1.0);
  }
  for (int block = 0; block < num_blocks; ++block) entries.emplace_back(block, block, 1.0);
  Eigen::SparseMatrix<double> pattern(num_blocks, num_blocks);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Lower>(), permutation);
  std::vector<int> order(num_blocks);
  // AMDOrdering returns the inverse: indices()[place] = block.
  for (int place = 0; place < num_blocks; ++place) order[permutation.indices()[place]] = place;
  return order;
}

/// C -= A B^T, column by column so that the compiler keeps one column of C in registers.
inline void subtract_product(Matrix6d& C, const Matrix6d& A, const Matrix6d& B) {
  for (int col = 0; col < 6; ++col) {
    Eigen::Matrix<double, 6, 1> sum = A.col(0) * B(col, 0);
    for (int k = 1; k < 6; ++k) sum += A.col(k) * B(col, k);
    C.col(col) -= sum;
  }
}

/// C -= A B.
inline void subtract_plain_product(Matrix6d& C, const Matrix6d& A, const Matrix6d& B) {
  for (int col = 0; col < 6; ++col) {
    Eigen::Matrix<double, 6, 1> sum = A.col(0) * B(0, col);
    for (int k = 1; k < 6; ++k) sum += A.col(k) * B(k, col);
    C.col(col) -= sum;
  }
}

}  // namespace

BlockCholesky::BlockCholesky(int num_blocks, std::span<const Position> off_diagonal)
    : order_(minimum_degree(num_blocks, off_diagonal)), parent_(num_blocks, -1) {
  // Structure of L, column by column: that of A below the diagonal, united with those of the
  // columns whose parent this one is (Davis, theorem 4.5).
  std::vector<std::vector<int>> lower(num_blocks);
  for (const auto& [row, col] : off_diagonal) {
    const auto [first, last] = std::minmax(order_[row], order_[col]);
    lower[first].push_back(last);
  }
  std::vector<std::vector<int>> children(num_blocks);
  begin_.assign(num_blocks + 1, 0);
  for (int col = 0; col < num_blocks; ++col) {
    std::vector<int>& below = lower[col];
    for (const int child : children[col]) {
      below.insert(below.end(), rows_.begin() + begin_[child] + 2,
                   rows_.begin() + begin_[child + 1]);
    }
    std::sort(below.begin(), below.end());
    below.erase(std::unique(below.begin(), below.end()), below.end());
    rows_.push_back(col);
    rows_.insert(rows_.end(), below.begin(), below.end());
    begin_[col + 1] = rows_.size();
    if (!below.empty()) {
      parent_[col] = below.front();
      children[below.front()].push_back(col);
    }
  }
  values_.assign(rows_.size(), Matrix6d::Zero());
}

std::size_t BlockCholesky::find(int row, int col) const {
  const auto first = rows_.begin() + begin_[col];
  return std::lower_bound(first, rows_.begin() + begin_[col + 1], row) - rows_.begin();
}

void BlockCholesky::add_diagonal(int block, const Matrix6d& value) {
  values_[begin_[order_[block]]] += value;
}

void BlockCholesky::add_off_diagonal(int row, int col, const Matrix6d& value) {
  const int row_place = order_[row];
  const int col_place = order_[col];
  if (row_place > col_place) {
    values_[find(row_place, col_place)] += value;
  } else {
    values_[find(col_place, row_place)] += value.transpose();
  }
}

std::optional<int> BlockCholesky::factor() {
  std::vector<Eigen::Matrix<double, 6, 1>> diagonal(num_blocks());
  for (int col = 0; col < num_blocks(); ++col) diagonal[col] = values_[begin_[col]].diagonal();
  for (int col = 0; col < num_blocks(); ++col) {
    const std::size_t first = begin_[col];
    const std::size_t end = begin_[col + 1];
    Matrix6d& pivot = values_[first];
    for (int k = 0; k < 6; ++k) {
      const double d = pivot(k, k) - pivot.row(k).head(k).squaredNorm();
      if (!(d > kMinPivotRatio * diagonal[col](k)) || !std::isfinite(d)) {
        return static_cast<int>(std::find(order_.begin(), order_.end(), col) - order_.begin());
      }
      pivot(k, k) = std::sqrt(d);
      for (int row = k + 1; row < 6; ++row) {
        pivot(row, k) =
            (pivot(row, k) - pivot.row(row).head(k).dot(pivot.row(k).head(k))) / pivot(k, k);
      }
      for (int row = 0; row < k; ++row) pivot(row, k) = 0.0;
    }
    for (std::size_t p = first + 1; p < end; ++p) {
      for (int k = 0; k < 6; ++k) {
        Eigen::Matrix<double, 6, 1> sum = values_[p].col(k);
        for (int m = 0; m < k; ++m) sum -= values_[p].col(m) * pivot(k, m);
        values_[p].col(k) = sum / pivot(k, k);
      }
    }
    // What this column takes from those right of it. Its rows from q on are a subset of column q's.
    for (std::size_t q = first + 1; q < end; ++q) {
      std::size_t target = begin_[rows_[q]];
      for (std::size_t p = q; p < end; ++p, ++target) {
        while (rows_[target] != rows_[p]) ++target;
        subtract_product(values_[target], values_[p], values_[q]);
      }
    }
  }
  return std::nullopt;
}

BlockCholesky::Column BlockCholesky::solve_unit(int block) const {
  Column x;
  for (int row = order_[block]; row >= 0; row = parent_[row]) x.rows.push_back(row);
  x.blocks.assign(x.rows.size(), Matrix6d::Zero());
  x.blocks.front().setIdentity();
  for (std::size_t k = 0; k < x.rows.size(); ++k) {
    const std::size_t first = begin_[x.rows[k]];
    const Matrix6d& pivot = values_[first];
    for (int row = 0; row < 6; ++row) {
      for (int m = 0; m < row; ++m) x.blocks[k].row(row) -= pivot(row, m) * x.blocks[k].row(m);
      x.blocks[k].row(row) /= pivot(row, row);
    }
    // The rows of a column of L are ancestors of it, so all of them are on the path.
    std::size_t target = k;
    for (std::size_t p = first + 1; p < begin_[x.rows[k] + 1]; ++p) {
      while (x.rows[target] != rows_[p]) ++target;
      subtract_plain_product(x.blocks[target], values_[p], x.blocks[k]);
    }
  }
  return x;
}

}  // namespace cloister
