#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace cloister::testing {

/// MD5 of some bytes as 32 hexadecimal digits (RFC 1321). For comparing with published digests, nothing else.
inline std::string md5(std::span<const std::byte> message) {
  // Section 3.1 and 3.2: a one bit, zeros up to 8 bytes short of a block, the length in bits.
  std::vector<std::byte> padded(message.begin(), message.end());
  padded.push_back(std::byte{0x80});
  padded.resize((padded.size() + 8 + 63) / 64 * 64);
  const std::uint64_t length_bits = 8 * static_cast<std::uint64_t>(message.size());
  std::memcpy(padded.data() + padded.size() - 8, &length_bits, 8);

  // Section 3.4: rotations per round and step, and the sine table.
  constexpr std::array<std::array<int, 4>, 4> kRotations = {
      {{7, 12, 17, 22}, {5, 9, 14, 20}, {4, 11, 16, 23}, {6, 10, 15, 21}}};
  std::array<std::uint32_t, 64> sines{};
  for (std::size_t i = 0; i < 64; ++i) {
    sines[i] = static_cast<std::uint32_t>(
        std::floor(4294967296.0 * std::abs(std::sin(static_cast<double>(i + 1)))));
  }

  std::array<std::uint32_t, 4> state = {0x67452301, 0xefcdab89, 0x98badcfe, 0x10325476};
  for (std::size_t start = 0; start < padded.size(); start += 64) {
    std::array<std::uint32_t, 16> words;
    std::memcpy(words.data(), padded.data() + start, 64);
    auto [a, b, c, d] = state;
    for (std::size_t step = 0; step < 64; ++step) {
      const std::size_t round = step / 16;
      std::uint32_t mix = 0;
      std::size_t word = 0;
      switch (round) {
        case 0:
          mix = (b & c) | (~b & d);
          word = step;
          break;
        case 1:
          mix = (b & d) | (c & ~d);
          word = (5 * step + 1) % 16;
          break;
        case 2:
          mix = b ^ c ^ d;
          word = (3 * step + 5) % 16;
          break;
        default:
          mix = c ^ (b | ~d);
          word = (7 * step) % 16;
      }
      const std::uint32_t turned =
          b + std::rotl(a + mix + words[word] + sines[step], kRotations[round][step % 4]);
      a = d;
      d = c;
      c = b;
      b = turned;
    }
    state[0] += a;
    state[1] += b;
    state[2] += c;
    state[3] += d;
  }

  std::string digits;
  for (const std::uint32_t word : state) {
    for (int byte = 0; byte < 4; ++byte) {
      const std::uint32_t value = (word >> (8 * byte)) & 0xff;
      digits += "0123456789abcdef"[value >> 4];
      digits += "0123456789abcdef"[value & 0xf];
    }
  }
  return digits;
}

/// The same over an array's values as they lie in memory.
template <typename Value>
std::string md5_of(const std::vector<Value>& values) {
  return md5(std::as_bytes(std::span(values)));
}

}  // namespace cloister::testing
