#include "firmware_interface/map/states_csv.hpp"

#include <string>
#include <string_view>

#include "firmware_interface/files/text_format.hpp"

namespace cloister {
namespace {

[[nodiscard]] std::string_view name_of(VoxelState state) {
  switch (state) {
    case VoxelState::kOccupied:
      return "occupied";
    case VoxelState::kFree:
      return "free";
    case VoxelState::kUnknown:
      break;
  }
  return "unknown";
}

}  // namespace

Result<void> write_states_csv(const MapQuery& query, std::span<const Eigen::Vector3d> points_M,
                              std::ostream& out) {
  constexpr std::size_t kFlushBytes = 1 << 16;
  std::string text = "x,y,z,state,log_odds,submap\n";
  const auto write_out = [&] {
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    text.clear();
    return out.good();
  };
  bool is_good = true;
  for (std::size_t i = 0; i < points_M.size() && is_good; ++i) {
    const QueryAnswer answer = query.at(points_M[i]);
    for (const double coordinate : points_M[i]) {
      append_number(text, coordinate);
      text += ',';
    }
    text += name_of(answer.state);
    text += ',';
    append_number(text, natural_log_odds(answer.log_odds));
    text += ',';
    append_number(text, answer.submap);
    text += '\n';
    if (text.size() > kFlushBytes) is_good = write_out();
  }
  if (!is_good || !write_out() || !out.flush()) {
    return fail(ErrorKind::kResource,
                "the states could not be written; check the disk or the reader of the output");
  }
  return {};
}

}  // namespace cloister
