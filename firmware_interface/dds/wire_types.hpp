#pragma once

#include <cloister_native.h>

#include <optional>
#include <vector>

#include "firmware_interface/dds/native_topics.hpp"

/// Between the generated message types and plain ones. For the sources of this folder only.
namespace cloister {

void to_wire(const Pose& T_A_B, double (&pose)[7]);
/// A quaternion that is none gives a pose that is not finite.
[[nodiscard]] Pose from_wire(const double (&pose)[7]);

[[nodiscard]] std::vector<cloister_wire_GraphPart> to_wire(const GraphUpdate& update);

/// False when the message contradicts itself, or is of another sensor.
[[nodiscard]] bool from_wire(const cloister_wire_OrganisedScan& message, int num_beams,
                             int num_columns, Scan& scan);
void to_wire(const Scan& scan, int num_beams, int num_columns, std::uint32_t scan_number,
             cloister_wire_OrganisedScan& message);

/// Puts the parts of graph updates together. Parts of one update come in any order; those of two do not mix.
class GraphParts {
 public:
  explicit GraphParts(Counters<TopicCause>& counters) : counters_(counters) {}
  /// @return the update that this part completes
  [[nodiscard]] std::optional<GraphUpdate> add(const cloister_wire_GraphPart& part);

 private:
  Counters<TopicCause>& counters_;
  GraphUpdate update_;
  std::vector<bool> has_part_;
  std::size_t num_missing_ = 0;
};

}  // namespace cloister
