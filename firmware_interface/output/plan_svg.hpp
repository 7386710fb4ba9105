#pragma once

#include <string>

#include "firmware_interface/output/plan.hpp"
#include "mapping/record/mission_record.hpp"

namespace cloister {

/// The mission's segmented plan as a picture of its own, storeys side by side, ready for a README:
/// SVG without external references, light or dark as the viewer prefers.
[[nodiscard]] std::string plan_svg(const MissionRecord& record);

/// One storey as an <svg> element, 1000 units wide, for a page that styles the classes `path`,
/// `start`, `end`, `label`, `rule` and `mark` (see report_style.hpp).
[[nodiscard]] std::string storey_svg(const MissionRecord& record, const Plan& plan,
                                     std::size_t storey);

/// "Floor at 2.9 m", or "Plan" when there is only one.
[[nodiscard]] std::string storey_title(const Plan& plan, std::size_t storey);

}  // namespace cloister
