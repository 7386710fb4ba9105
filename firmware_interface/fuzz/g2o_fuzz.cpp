#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "firmware_interface/files/g2o_file.hpp"

/// Any text is either refused or gives a graph that keeps what PoseGraph promises.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  // With and without a default for missing information: without one, such edges are refused.
  for (const double default_information : {0.0, 1.0}) {
    const auto graph = cloister::read_g2o(text, "input", {default_information});
    if (!graph) continue;
    for (std::size_t k = 0; k < graph->nodes.size(); ++k) {
      if (!cloister::is_finite(graph->nodes[k].T_M_N)) std::abort();
      if (k > 0 && graph->nodes[k - 1].id >= graph->nodes[k].id) std::abort();
    }
    for (const auto& edge : graph->edges) {
      if (edge.from == edge.to || graph->find(edge.from) < 0 || graph->find(edge.to) < 0)
        std::abort();
      if (!cloister::is_finite(edge.T_from_to) || !edge.information.allFinite()) std::abort();
    }
  }
  return 0;
}
