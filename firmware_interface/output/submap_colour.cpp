#include "firmware_interface/output/submap_colour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

namespace cloister {
namespace {

// From Oklab (Ottosson 2020), where equal steps look equal; nothing when sRGB lacks the colour.
std::optional<Rgb> srgb_from_oklch(double lightness, double chroma, double hue_rad) {
  const double a = chroma * std::cos(hue_rad);
  const double b = chroma * std::sin(hue_rad);
  const auto cube = [](double x) { return x * x * x; };
  const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
  const double m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
  const double s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
  const std::array<double, 3> linear = {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                                        -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                                        -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
  std::array<std::uint8_t, 3> channel = {};
  for (std::size_t i = 0; i < 3; ++i) {
    if (linear[i] < 0.0 || linear[i] > 1.0) return std::nullopt;
    const double encoded =
        linear[i] <= 0.0031308 ? 12.92 * linear[i] : 1.055 * std::pow(linear[i], 1 / 2.4) - 0.055;
    channel[i] = static_cast<std::uint8_t>(std::lround(255.0 * encoded));
  }
  return Rgb{channel[0], channel[1], channel[2]};
}

}  // namespace

Rgb submap_colour(SubmapId id) {
  // The golden angle never comes back to a hue it has used, and keeps any few ids in a row apart.
  constexpr double kGoldenAngle_rad = 2.399963229728653;  // pi * (3 - sqrt(5))
  constexpr std::array<double, 3> kLightness = {0.66, 0.58, 0.74};
  const auto index = static_cast<unsigned>(std::max(id, 0));
  const double hue_rad = 4.4 + kGoldenAngle_rad * index;
  for (double chroma = 0.16; chroma > 0.0; chroma -= 0.01) {
    if (const auto rgb = srgb_from_oklch(kLightness[index % 3], chroma, hue_rad)) return *rgb;
  }
  return {128, 128, 128};
}

std::string hex_colour(Rgb colour) {
  char text[8];
  std::snprintf(text, sizeof(text), "#%02x%02x%02x", colour.r, colour.g, colour.b);
  return text;
}

}  // namespace cloister
