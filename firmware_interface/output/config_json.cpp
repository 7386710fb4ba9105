#include "firmware_interface/output/config_json.hpp"

#include <string_view>

#include "mapping/core/config_fields.hpp"

namespace cloister {

nlohmann::ordered_json config_json(const Config& config) {
  nlohmann::ordered_json json;
  visit_fields(config, [&json](std::string_view name, const auto& value, auto, auto) {
    const std::size_t dot = name.find('.');
    if (dot == std::string_view::npos) {
      json[std::string(name)] = value;
    } else {
      json[std::string(name.substr(0, dot))][std::string(name.substr(dot + 1))] = value;
    }
  });
  return json;
}

}  // namespace cloister
