#include "runtime/config_file.hpp"

#include <charconv>
#include <cmath>
#include <sstream>
#include <type_traits>

#include <toml++/toml.h>

namespace cloister {
namespace {

/// Sets one field from a TOML value. Returns what is wrong, without the field's name, or nothing.
template <typename Field>
std::optional<std::string> assign(const toml::node& node, Field& field, double least, double most) {
  std::ostringstream bounds;
  bounds << "must be ";
  if constexpr (std::is_same_v<Field, bool>) {
    if (const auto value = node.value_exact<bool>()) {
      field = *value;
      return std::nullopt;
    }
    bounds << "true or false";
  } else if constexpr (std::is_same_v<Field, std::string>) {
    const auto value = node.value_exact<std::string>();
    if (value && static_cast<double>(value->size()) >= least && static_cast<double>(value->size()) <= most) {
      field = *value;
      return std::nullopt;
    }
    bounds << "a text of " << least << " to " << most << " characters, in quotes";
  } else {
    bounds << (std::is_integral_v<Field> ? "a whole number" : "a number") << " between " << least << " and " << most;
    const auto value = node.is_integer() ? std::optional<double>(static_cast<double>(*node.value_exact<std::int64_t>()))
                                         : node.value_exact<double>();
    const bool fits = value && std::isfinite(*value) && *value >= least && *value <= most;
    if (fits && (std::is_floating_point_v<Field> || *value == std::floor(*value))) {
      field = static_cast<Field>(*value);
      return std::nullopt;
    }
  }
  return bounds.str();
}

std::string text_of(const toml::node& node) {
  std::ostringstream text;
  text << toml::node_view<const toml::node>(&node);
  return text.str();
}

/// Applies a parsed table to the configuration. `origin(node)` says where a value was written.
template <typename Origin>
Result<void> apply(const toml::table& table, ProgramConfig& config, Origin&& origin) {
  std::optional<Error> error;
  const auto set = [&](const std::string& name, const toml::node& node) {
    if (error) return;
    bool is_known = false;
    visit_program_fields(config, [&](const char* field_name, auto& field, double least, double most) {
      if (name != field_name) return;
      is_known = true;
      if (const auto problem = assign(node, field, least, most)) {
        error = Error{ErrorKind::kUsage, origin(node) + name + " = " + text_of(node) + ": " + *problem};
      }
    });
    if (!is_known) {
      error = Error{ErrorKind::kUsage, origin(node) + name + ": no such setting; `cloister config` lists them all"};
    }
  };
  for (const auto& [key, node] : table) {
    if (const toml::table* inner = node.as_table()) {
      for (const auto& [inner_key, inner_node] : *inner) {
        set(std::string(key.str()) + "." + std::string(inner_key.str()), inner_node);
      }
    } else {
      set(std::string(key.str()), node);
    }
  }
  if (error) return tl::unexpected(*error);
  return {};
}

/// A shell takes quotes away: what stands behind the `=` of a setting that is no TOML is a text as it is.
toml::table parse_bare_text(const std::string& setting) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || setting.find_first_of("\"'\n", equals) != std::string::npos) return {};
  try {
    return toml::parse(setting.substr(0, equals + 1) + '"' + setting.substr(equals + 1) + '"');
  } catch (const toml::parse_error&) {
    return {};
  }
}

}  // namespace

Result<ProgramConfig> load_config(const std::optional<std::filesystem::path>& file,
                                  const std::vector<std::string>& settings) {
  ProgramConfig config;
  if (file) {
    const std::string path = file->string();
    if (!std::filesystem::is_regular_file(*file)) return fail(ErrorKind::kUsage, path + ": no such configuration file");
    toml::table table;
    try {
      table = toml::parse_file(path);
    } catch (const toml::parse_error& error) {
      return fail(ErrorKind::kUsage, path + ":" + std::to_string(error.source().begin.line) + ": " +
                                         std::string(error.description()));
    }
    const auto origin = [&](const toml::node& node) {
      return path + ":" + std::to_string(node.source().begin.line) + ": ";
    };
    if (auto applied = apply(table, config, origin); !applied) return tl::unexpected(applied.error());
  }
  for (const std::string& setting : settings) {
    toml::table table;
    try {
      table = toml::parse(setting);
    } catch (const toml::parse_error&) {
      table = parse_bare_text(setting);
    }
    if (table.empty()) {
      return fail(ErrorKind::kUsage, "--set " + setting + ": must be key=value, as in voxel.voxel_size_m=0.1");
    }
    const auto origin = [](const toml::node&) { return std::string("--set "); };
    if (auto applied = apply(table, config, origin); !applied) return tl::unexpected(applied.error());
  }
  if (const auto problem = validate(config.map)) return fail(ErrorKind::kUsage, *problem);
  return config;
}

std::string to_toml(const ProgramConfig& config) {
  std::ostringstream text;
  text << std::boolalpha;
  std::string open_table;
  // Plain values go before the first table.
  text << "baseline = " << config.map.baseline << "\n";
  visit_program_fields(config, [&](const char* name, const auto& value, double least, double most) {
    const std::string full = name;
    const std::size_t dot = full.find('.');
    if (dot == std::string::npos) return;
    if (full.substr(0, dot) != open_table) {
      open_table = full.substr(0, dot);
      text << "\n[" << open_table << "]\n";
    }
    text << full.substr(dot + 1) << " = ";
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::string>) {
      text << toml::value<std::string>(value) << "  # " << least << " to " << most << " characters\n";
      return;
    } else if constexpr (std::is_same_v<Value, bool>) {
      text << (value ? "true" : "false") << "\n";
      return;
    } else if constexpr (std::is_floating_point_v<Value>) {
      char digits[32];
      const auto end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
      const std::string written(digits, end);
      text << written << (written.find_first_of(".e") == std::string::npos ? ".0" : "");
    } else {
      text << value;
    }
    text << "  # " << least << " to " << most << "\n";
  });
  return text.str();
}

}  // namespace cloister
