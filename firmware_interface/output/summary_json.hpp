#pragma once

#include <string>

#include "mapping/record/mission_record.hpp"

namespace cloister {

/// The text of summary.json: one object, keys and units as documented for users, doubles in the
/// shortest form that reads back the same, numbers that are not finite as null, `map_hash` as "0x"
/// and 16 hexadecimal digits. Invalid UTF-8 in names is replaced.
[[nodiscard]] std::string summary_json(const MissionRecord& record);

}  // namespace cloister
