#pragma once

#include <filesystem>

#include "mapping/core/result.hpp"
#include "mapping/record/mission_record.hpp"

namespace cloister {

/// Writes what a mission leaves behind beside its voxels and meshes: submaps.json, timeline.csv,
/// events.jsonl, trajectory.tum, plan.svg, report.html and, last of all, summary.json. The
/// directory is made where it is missing. Each file appears whole or not at all; the first that
/// fails ends it with kResource naming its path.
[[nodiscard]] Result<void> write_mission_outputs(const MissionRecord& record,
                                                 const std::filesystem::path& out);

}  // namespace cloister
