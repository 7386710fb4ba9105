#include "mapping/graph/block_cholesky.hpp"

#include <limits>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <doctest/doctest.h>

namespace cloister {
namespace {

/// The same symmetric system twice: sparse in blocks, and dense.
struct System {
  BlockCholesky sparse;
  Eigen::MatrixXd dense;

  System(int num_blocks, const std::vector<BlockCholesky::Position>& positions)
      : sparse(num_blocks, positions),
        dense(Eigen::MatrixXd::Zero(6 * num_blocks, 6 * num_blocks)) {}

  void add_diagonal(int block, const Matrix6d& value) {
    sparse.add_diagonal(block, value);
    dense.block<6, 6>(6 * block, 6 * block) += value;
  }
  void add_off_diagonal(int row, int col, const Matrix6d& value) {
    sparse.add_off_diagonal(row, col, value);
    dense.block<6, 6>(6 * row, 6 * col) += value;
    dense.block<6, 6>(6 * col, 6 * row) += value.transpose();
  }
};

Matrix6d random_matrix(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return Matrix6d::NullaryExpr([&] { return uniform(random); });
}

/// Sum of J^T J over random pairs, plus a little on the diagonal: positive definite, with random
/// fill.
System random_system(std::mt19937& random, int num_blocks, int num_pairs) {
  std::uniform_int_distribution<int> pick(0, num_blocks - 1);
  std::vector<BlockCholesky::Position> positions;
  while (static_cast<int>(positions.size()) < num_pairs) {
    const int row = pick(random);
    const int col = pick(random);
    if (row != col) positions.emplace_back(row, col);
  }
  System system(num_blocks, positions);
  for (int block = 0; block < num_blocks; ++block)
    system.add_diagonal(block, 0.1 * Matrix6d::Identity());
  for (const auto& [row, col] : positions) {
    const Matrix6d J_row = random_matrix(random);
    const Matrix6d J_col = random_matrix(random);
    system.add_diagonal(row, J_row.transpose() * J_row);
    system.add_diagonal(col, J_col.transpose() * J_col);
    system.add_off_diagonal(row, col, J_row.transpose() * J_col);
  }
  return system;
}

/// Block (a, b) of A^-1 from two sparse columns.
Matrix6d inverse_block(const BlockCholesky& factor, int a, int b) {
  const BlockCholesky::Column x = factor.solve_unit(a);
  const BlockCholesky::Column y = factor.solve_unit(b);
  Matrix6d sum = Matrix6d::Zero();
  for (std::size_t p = 0; p < x.rows.size(); ++p) {
    for (std::size_t q = 0; q < y.rows.size(); ++q) {
      if (x.rows[p] == y.rows[q]) sum += x.blocks[p].transpose() * y.blocks[q];
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("every block of the inverse agrees with a dense inverse") {
  constexpr unsigned seed = 21;
  CAPTURE(seed);
  std::mt19937 random(seed);
  for (const auto& [num_blocks, num_pairs] :
       {std::pair{1, 0}, {2, 1}, {2, 5}, {7, 9}, {20, 22}, {20, 90}, {20, 0}}) {
    CAPTURE(num_blocks);
    CAPTURE(num_pairs);
    System system = random_system(random, num_blocks, num_pairs);
    REQUIRE_FALSE(system.sparse.factor().has_value());
    const Eigen::MatrixXd inverse = system.dense.inverse();
    for (int a = 0; a < num_blocks; ++a) {
      for (int b = 0; b < num_blocks; ++b) {
        const Matrix6d expected = inverse.block<6, 6>(6 * a, 6 * b);
        CHECK((inverse_block(system.sparse, a, b) - expected).norm() <
              1e-10 * (1.0 + expected.norm()));
      }
    }
  }
}

TEST_CASE("a system without blocks is factored") {
  BlockCholesky empty(0, {});
  CHECK_FALSE(empty.factor().has_value());
}

TEST_CASE("a chain of blocks fills in nothing") {
  std::vector<BlockCholesky::Position> positions;
  for (int block = 0; block + 1 < 50; ++block) positions.emplace_back(block + 1, block);
  CHECK(BlockCholesky(50, positions).num_factor_blocks() == 99);
}

TEST_CASE("the block is named at which a matrix turns out not to be positive definite") {
  const std::vector<BlockCholesky::Position> positions = {{0, 1}};
  Matrix6d bad = Matrix6d::Identity();
  SUBCASE("indefinite") { bad(4, 4) = -1.0; }
  SUBCASE("singular") { bad(4, 4) = 0.0; }
  SUBCASE("singular to working precision") {
    bad.topLeftCorner<2, 2>() << 1.0, 1.0, 1.0, 1.0 + 1e-15;
  }
  SUBCASE("not a number") { bad(4, 4) = std::numeric_limits<double>::quiet_NaN(); }
  SUBCASE("infinite") { bad(4, 4) = std::numeric_limits<double>::infinity(); }
  BlockCholesky factor(3, positions);
  factor.add_diagonal(0, Matrix6d::Identity());
  factor.add_diagonal(1, Matrix6d::Identity());
  factor.add_diagonal(2, bad);
  CHECK(factor.factor() == 2);
}

}  // namespace cloister
