#pragma once

#include <chrono>
#include <string>

#include "mapping/core/result.hpp"

namespace cloister {

/// Asks a sensor for its metadata: `GET http://HOST/api/v1/sensor/metadata` by HTTP/1.1, one request, IPv4 or IPv6.
/// @param host     address or name, with `:port` behind it where that is not 80
/// @param timeout  for all of it
/// @return the body; kResource, naming the URL, when the sensor cannot be reached in time or does not answer 200
[[nodiscard]] Result<std::string> fetch_sensor_metadata(const std::string& host,
                                                        std::chrono::milliseconds timeout);

}  // namespace cloister
