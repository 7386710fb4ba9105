#pragma once

#include <filesystem>
#include <span>

#include "firmware_interface/map/map_contents.hpp"
#include "mapping/core/result.hpp"
#include "runtime/pipeline.hpp"

namespace cloister {

/// These submaps of the pipeline's as a map.
[[nodiscard]] MapView view_of(const Pipeline& pipeline, std::span<const Submap* const> submaps);

/// Writes everything that a mission leaves behind. After Pipeline::finish(). Each file appears whole or not at all.
[[nodiscard]] Result<void> write_outputs(const Pipeline& pipeline,
                                         const std::filesystem::path& out);

/// Writes only the map as it stands, `map.cloister`. Waits until nothing is under way.
[[nodiscard]] Result<void> save_present_map(Pipeline& pipeline, const std::filesystem::path& out);

}  // namespace cloister
