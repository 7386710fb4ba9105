#pragma once

#include <optional>
#include <vector>

#include "bench/simulate/graph_optimizer.hpp"
#include "bench/simulate/random_stream.hpp"

namespace cloister {

/// What a wrong loop closure says about itself.
enum class Confidence {
  kDoubtful,  ///< its standard deviations are as large as its error
  kConfident  ///< those of a good one
};

/// A loop closure from the newest node to an old one that is 7 to 20 m away, mistaken for the same
/// place. @param T_W_nodes true poses @param min_gap nodes between the two ends
/// @param good_sigma standard deviations of a good closure
/// @return nothing when no node is that far away
[[nodiscard]] std::optional<RelativeMeasurement> make_wrong_closure(
    const std::vector<Pose>& T_W_nodes, std::size_t min_gap, const Vector6d& good_sigma,
    Confidence confidence, RandomStream* random);

/// A pose graph with an error in it.
struct FaultyGraph {
  std::vector<Pose> T_M_nodes;
  std::vector<RelativeMeasurement> measurements;
};

/// An error of the old half of the graph that the optimiser finds late.
///
/// Until then the first third of all nodes stands aside by some metres, the nodes up to the middle
/// by less and less, as if odometry had drifted there; places of the old half that are seen again
/// are not recognised. Then these loop closures arrive together and the old half moves into place.
class LateShift {
 public:
  /// @param num_nodes of the whole mission
  LateShift(double shift_m, std::size_t num_nodes) : shift_m_(shift_m), num_nodes_(num_nodes) {}

  /// True for graphs with so few nodes that the error is not found yet.
  [[nodiscard]] bool is_unnoticed(std::size_t nodes) const;
  /// The graph with the error. Every measurement left keeps its residual.
  [[nodiscard]] FaultyGraph apply(const std::vector<Pose>& T_M_nodes,
                                  const std::vector<RelativeMeasurement>& measurements) const;

 private:
  [[nodiscard]] double offset_m(std::size_t node) const;

  double shift_m_;
  std::size_t num_nodes_;
};

}  // namespace cloister
