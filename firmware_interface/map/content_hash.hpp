#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>

struct XXH3_state_s;

namespace cloister {

/// XXH3-64 of a stream of bytes.
class ContentHash {
 public:
  ContentHash();

  void add(const void* bytes, std::size_t size);
  template <typename Value>
  requires std::has_unique_object_representations_v<Value>
  void add_value(const Value& value) { add(&value, sizeof(value)); }
  /// Of everything added since construction or the last reset.
  [[nodiscard]] std::uint64_t digest() const;
  void reset();

 private:
  struct Free {
    void operator()(XXH3_state_s* state) const;
  };
  std::unique_ptr<XXH3_state_s, Free> state_;
};

}  // namespace cloister
