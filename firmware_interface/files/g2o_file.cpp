#include "firmware_interface/files/g2o_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Cholesky>

#include "firmware_interface/files/line_reader.hpp"
#include "firmware_interface/files/read_file.hpp"

namespace cloister {
namespace {

constexpr double kEigenvalueTolerance = 1e-6;

struct NodeLine {
  GraphNode node;
  std::size_t line_number = 0;
};

bool same_content(const GraphNode& a, const GraphNode& b) {
  return a.has_stamp == b.has_stamp && a.stamp == b.stamp && a.T_M_N.matrix() == b.T_M_N.matrix();
}

/// True when the matrix, its diagonal scaled to one, has no eigenvalue below -kEigenvalueTolerance.
bool is_positive_semidefinite(const Matrix6d& information) {
  Matrix6d scaled;
  for (int column = 0; column < 6; ++column) {
    for (int row = column + 1; row < 6; ++row) {
      const double entry = information(row, column);
      const double scale =
          std::sqrt(information(row, row)) * std::sqrt(information(column, column));
      scaled(row, column) = entry == 0.0 ? 0.0 : entry / scale;
      // Also false for a negative or zero diagonal, where the quotient is not a number or infinite.
      if (!(std::abs(scaled(row, column)) <= 1.0 + kEigenvalueTolerance)) return false;
    }
    if (information(column, column) < 0.0) return false;
    scaled(column, column) = 1.0 + kEigenvalueTolerance;
  }
  return Eigen::LLT<Matrix6d, Eigen::Lower>(scaled).info() == Eigen::Success;
}

bool is_record_name(std::string_view field) {
  const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  return is_letter(field.front()) && std::ranges::all_of(field, [&](char c) {
           return is_letter(c) || (c >= '0' && c <= '9') || c == '_' || c == ':' || c == '-';
         });
}

/// What is read from one text: first line by line, then made into a graph.
class G2oReader {
 public:
  G2oReader(std::string_view text, std::string_view file_name, const G2oOptions& options)
      : line_(text, file_name), options_(options) {
    // Edges with information are 150 characters and more; too small a guess only costs a copy.
    edges_.reserve(text.size() / 256);
    edge_lines_.reserve(text.size() / 256);
  }

  Result<PoseGraph> read(G2oStats& stats) {
    while (line_.next_line()) {
      const std::string_view record = *line_.next_field();
      std::optional<Error> error;
      if (record == "VERTEX_SE3:QUAT_TIME") {
        error = read_vertex(true);
      } else if (record == "VERTEX_SE3:QUAT") {
        error = read_vertex(false);
      } else if (record == "EDGE_SE3:QUAT") {
        error = read_edge(stats);
      } else if (is_record_name(record)) {
        ++stats.skipped_records;
      } else {
        error =
            line_.failure("the line does not begin with the name of a record; is this a g2o file?")
                .value();
      }
      if (error) return tl::unexpected(std::move(*error));
    }
    stats.comments = static_cast<std::int64_t>(line_.num_comment_lines());
    return finish(stats);
  }

 private:
  std::optional<Error> read_vertex(bool with_stamp) {
    NodeLine& added = nodes_.emplace_back();
    added.line_number = line_.line_number();
    GraphNode& node = added.node;
    if (!line_.read(node.id) || !line_.read(node.T_M_N)) return line_.failure().value();
    if (node.id < 0)
      return line_.failure("a vertex id is negative; number vertices from 0").value();
    if (with_stamp) {
      std::int64_t seconds = 0;
      std::int64_t nanoseconds = 0;
      if (!line_.read(seconds) || !line_.read(nanoseconds)) return line_.failure().value();
      const auto stamp = make_stamp(seconds, nanoseconds);
      if (!stamp) {
        return line_.failure("the stamp is not 'sec nsec' with 0 <= nsec < 1e9; correct it")
            .value();
      }
      node.stamp = *stamp;
      node.has_stamp = true;
    }
    if (!line_.read_end()) return line_.failure().value();
    return std::nullopt;
  }

  std::optional<Error> read_edge(G2oStats& stats) {
    GraphEdge& edge = edges_.emplace_back();
    edge_lines_.push_back(line_.line_number());
    if (!line_.read(edge.from) || !line_.read(edge.to) || !line_.read(edge.T_from_to)) {
      return line_.failure().value();
    }
    if (edge.from == edge.to) {
      return line_.failure("an edge joins a node to itself; remove the line").value();
    }
    if (line_.at_line_end()) {
      if (!(options_.default_information > 0.0)) {
        return line_
            .failure(
                "the edge has no information matrix; write its 21 entries, or set "
                "fusion.default_information")
            .value();
      }
      edge.information = options_.default_information * Matrix6d::Identity();
      edge.has_information = false;
      ++stats.edges_without_information;
      return std::nullopt;
    }
    std::array<double, 21> upper;
    if (!line_.read(std::span<double>(upper)) || !line_.read_end()) return line_.failure().value();
    const double* entry = upper.data();
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        edge.information(row, column) = edge.information(column, row) = *entry++;
      }
    }
    if (!is_positive_semidefinite(edge.information)) {
      return line_
          .failure(
              "the information matrix is not positive semidefinite; correct or remove the edge")
          .value();
    }
    return std::nullopt;
  }

  Result<PoseGraph> finish(G2oStats& stats) {
    const auto by_id = [](const NodeLine& a, const NodeLine& b) { return a.node.id < b.node.id; };
    if (!std::ranges::is_sorted(nodes_, by_id)) std::ranges::stable_sort(nodes_, by_id);

    PoseGraph graph;
    graph.nodes.reserve(nodes_.size());
    for (const NodeLine& next : nodes_) {
      if (graph.nodes.empty() || graph.nodes.back().id != next.node.id) {
        graph.nodes.push_back(next.node);
      } else if (same_content(graph.nodes.back(), next.node)) {
        ++stats.repeated_vertices;
      } else {
        return line_.failure_at(next.line_number,
                                "vertex " + std::to_string(next.node.id) +
                                    " was written before with other content; keep one of the two");
      }
    }
    for (std::size_t k = 0; k < edges_.size(); ++k) {
      for (const NodeId id : {edges_[k].from, edges_[k].to}) {
        if (graph.find(id) >= 0) continue;
        return line_.failure_at(edge_lines_[k],
                                "the edge names node " + std::to_string(id) +
                                    ", which has no vertex; add it or remove the edge");
      }
    }
    graph.edges = std::move(edges_);
    return graph;
  }

  LineReader line_;
  const G2oOptions& options_;
  std::vector<NodeLine> nodes_;
  std::vector<GraphEdge> edges_;
  std::vector<std::size_t> edge_lines_;
};

}  // namespace

Result<PoseGraph> read_g2o(std::string_view text, std::string_view file_name,
                           const G2oOptions& options, G2oStats* stats) {
  G2oStats unused;
  G2oStats& filled = stats != nullptr ? *stats : unused;
  filled = {};
  return G2oReader(text, file_name, options).read(filled);
}

Result<PoseGraph> load_g2o(const std::filesystem::path& path, const G2oOptions& options,
                           G2oStats* stats) {
  const Result<std::string> text = read_file(path);
  if (!text) return tl::unexpected(text.error());
  return read_g2o(*text, path.string(), options, stats);
}

}  // namespace cloister
