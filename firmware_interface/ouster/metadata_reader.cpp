#include "firmware_interface/ouster/metadata_reader.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace cloister {
namespace {

using nlohmann::json;

constexpr double kMetresPerMm = 1e-3;
constexpr double kRigidTolerance = 1e-4;
constexpr double kMaxTransformEntry = 1e5;

std::string number_text(double number) { return json(number).dump(); }

}  // namespace

int line_of_byte(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  return 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n'));
}

void MetadataReader::refuse(std::string_view key, const std::string& what,
                            const std::string& index) {
  if (error_) return;
  const std::size_t byte = text_.find('"' + std::string(key) + '"');
  const std::string line =
      byte == std::string_view::npos ? "" : ":" + std::to_string(line_of_byte(text_, byte));
  error_ = Error{ErrorKind::kInput, std::string(file_name_) + line + ": " + std::string(key) +
                                        index + " " + what + "; use the sensor's own metadata"};
}

const json* MetadataReader::find(std::string_view key, Sections sections) const {
  for (const char* section : sections) {
    const json* object = &root_;
    if (*section != '\0') {
      const auto found = root_.find(section);
      if (found == root_.end()) continue;
      object = &*found;
    }
    if (!object->is_object()) continue;
    const auto found = object->find(key);
    if (found != object->end() && !found->is_null()) return &*found;
  }
  return nullptr;
}

std::optional<std::string> MetadataReader::string(std::string_view key, Sections sections) {
  const json* value = find(key, sections);
  if (value == nullptr) return std::nullopt;
  if (value->is_string()) return value->get<std::string>();
  refuse(key, "is not a string");
  return std::nullopt;
}

std::optional<double> MetadataReader::number(std::string_view key, Sections sections,
                                             double max_magnitude) {
  const json* value = find(key, sections);
  if (value == nullptr) return std::nullopt;
  return to_number(*value, key, "", max_magnitude);
}

std::optional<int> MetadataReader::integer(std::string_view key, Sections sections, int min,
                                           int max) {
  const json* value = find(key, sections);
  if (value == nullptr) return std::nullopt;
  return to_integer(*value, key, "", min, max);
}

template <typename Visit>
void MetadataReader::for_each(std::string_view key, Sections sections, Visit visit) {
  const json* list = find(key, sections);
  if (list == nullptr) return;
  if (!list->is_array()) return refuse(key, "is not a list");
  for (std::size_t i = 0; i < list->size(); ++i) visit((*list)[i], "[" + std::to_string(i) + "]");
}

std::vector<double> MetadataReader::numbers(std::string_view key, Sections sections,
                                            double max_magnitude) {
  std::vector<double> values;
  for_each(key, sections, [&](const json& value, const std::string& index) {
    values.push_back(to_number(value, key, index, max_magnitude).value_or(0.0));
  });
  return values;
}

std::vector<int> MetadataReader::integers(std::string_view key, Sections sections, int min,
                                          int max) {
  std::vector<int> values;
  for_each(key, sections, [&](const json& value, const std::string& index) {
    values.push_back(to_integer(value, key, index, min, max).value_or(0));
  });
  return values;
}

std::optional<Pose> MetadataReader::transform(std::string_view key, Sections sections) {
  if (!has(key, sections)) return std::nullopt;
  const std::vector<double> values = numbers(key, sections, kMaxTransformEntry);
  if (values.size() != 16) {
    refuse(key, "has " + std::to_string(values.size()) + " entries instead of 16");
    return std::nullopt;
  }
  const Eigen::Matrix4d matrix =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const bool is_rigid = (rotation.transpose() * rotation).isIdentity(kRigidTolerance) &&
                        rotation.determinant() > 0.0 &&
                        matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), kRigidTolerance);
  if (!is_rigid) {
    refuse(key, "is not a rotation and a shift");
    return std::nullopt;
  }
  Pose pose = Pose::Identity();
  pose.linear() = rotation;
  pose.translation() = matrix.topRightCorner<3, 1>() * kMetresPerMm;
  return pose;
}

std::optional<double> MetadataReader::to_number(const json& value, std::string_view key,
                                                const std::string& index, double max_magnitude) {
  if (!value.is_number()) {
    refuse(key, "is not a number", index);
    return std::nullopt;
  }
  const double number = value.get<double>();
  if (!(std::abs(number) <= max_magnitude)) {
    refuse(key, "= " + number_text(number) + " is not within +-" + number_text(max_magnitude),
           index);
    return std::nullopt;
  }
  return number;
}

std::optional<int> MetadataReader::to_integer(const json& value, std::string_view key,
                                              const std::string& index, int min, int max) {
  // By way of a double, into which every JSON number goes without wrapping around.
  const double number = value.is_number() ? value.get<double>() : 0.0;
  if (!value.is_number() || number != std::floor(number)) {
    refuse(key, "is not a whole number", index);
    return std::nullopt;
  }
  if (number < min || number > max) {
    refuse(key,
           "= " + number_text(number) + " is not within " + std::to_string(min) + " to " +
               std::to_string(max),
           index);
    return std::nullopt;
  }
  return static_cast<int>(number);
}

}  // namespace cloister
