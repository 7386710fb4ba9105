#include "mapping/core/config.hpp"

namespace cloister {

std::optional<std::string> validate(const Config&) { return std::nullopt; }

}  // namespace cloister
