#include "firmware_interface/files/mission_json.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

namespace cloister {
namespace {

using nlohmann::json;

tl::unexpected<Error> fail_at(std::string_view text, std::size_t byte, std::string_view file_name,
                              std::string_view problem) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const auto line = 1 + std::ranges::count(before, '\n');
  return fail(ErrorKind::kInput,
              std::string(file_name) + ":" + std::to_string(line) + ": " + std::string(problem));
}

/// A failure at the line where a key stands.
tl::unexpected<Error> fail_at_key(std::string_view text, std::string_view key,
                                  std::string_view file_name, std::string_view problem) {
  const auto byte = text.find("\"" + std::string(key) + "\"");
  return fail_at(text, byte == text.npos ? 0 : byte, file_name,
                 std::string(key) + " " + std::string(problem));
}

/// All numbers of an array of numbers, or of an array of such arrays;
/// empty when there is anything else.
std::vector<double> flattened(const json& value) {
  std::vector<double> numbers;
  if (!value.is_array()) return numbers;
  for (const json& item : value) {
    if (item.is_number()) {
      numbers.push_back(item.get<double>());
    } else if (item.is_array() &&
               std::ranges::all_of(item, [](const json& x) { return x.is_number(); })) {
      for (const json& x : item) numbers.push_back(x.get<double>());
    } else {
      return {};
    }
  }
  return numbers;
}

/// A pose from 7 or 16 numbers, or nothing when they are not one.
std::optional<Pose> to_pose(const std::vector<double>& numbers) {
  constexpr double kTolerance = 0.01;
  if (numbers.size() == 7) {
    const Eigen::Quaterniond q(numbers[6], numbers[3], numbers[4], numbers[5]);
    if (!(std::abs(q.norm() - 1.0) <= kTolerance)) return std::nullopt;
    return make_pose({numbers[0], numbers[1], numbers[2]}, q);
  }
  if (numbers.size() != 16) return std::nullopt;
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> T(numbers.data());
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const bool is_rotation =
      (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= kTolerance &&
      R.determinant() > 0.0;
  const bool is_affine = T.row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
  if (!is_rotation || !is_affine) return std::nullopt;
  return make_pose(T.topRightCorner<3, 1>(), Eigen::Quaterniond(R));
}

}  // namespace

Result<MissionJson> read_mission_json(std::string_view text, std::string_view file_name) {
  json document;
  try {
    document = json::parse(text, nullptr, true, true);
  } catch (const json::parse_error& error) {
    return fail_at(text, error.byte, file_name, "the text is not JSON here; correct it");
  } catch (const json::exception&) {  // for example a number too large for a double
    return fail_at(text, 0, file_name, "the text is not JSON; correct it");
  }
  if (!document.is_object()) return fail_at(text, 0, file_name, "the text is not a JSON object");

  MissionJson mission;
  for (const auto& [key, field] : {std::pair("name", &mission.name),
                                   std::pair("points_topic", &mission.points_topic),
                                   std::pair("odometry_topic", &mission.odometry_topic),
                                   std::pair("path_topic", &mission.path_topic)}) {
    const auto it = document.find(key);
    if (it == document.end()) continue;
    if (!it->is_string()) return fail_at_key(text, key, file_name, "is not a string; quote it");
    *field = it->get<std::string>();
  }
  if (const auto it = document.find("variant"); it != document.end()) {
    if (*it == "pcap") {
      mission.variant = MissionVariant::kPackets;
    } else if (*it == "individual_clouds") {
      mission.variant = MissionVariant::kClouds;
    } else {
      return fail_at_key(text, "variant", file_name,
                         "is neither \"pcap\" nor \"individual_clouds\"");
    }
  }
  if (const auto it = document.find("T_pose_sensor"); it != document.end()) {
    mission.T_pose_sensor = to_pose(flattened(*it));
    if (!mission.T_pose_sensor || !is_finite(*mission.T_pose_sensor)) {
      return fail_at_key(text, "T_pose_sensor", file_name,
                         "is neither [x,y,z,qx,qy,qz,qw] nor a 4x4 matrix of a rigid transform");
    }
    mission.pose_frame = PoseFrame::kBody;
  } else if (const auto frame = document.find("pose_frame"); frame != document.end()) {
    if (*frame == "lidar") {
      mission.pose_frame = PoseFrame::kLidar;
    } else if (*frame != "sensor") {
      return fail_at_key(
          text, "pose_frame", file_name,
          "is neither \"sensor\" nor \"lidar\"; give T_pose_sensor for another frame");
    }
  }
  return mission;
}

}  // namespace cloister
