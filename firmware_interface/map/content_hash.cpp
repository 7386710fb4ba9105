#include "firmware_interface/map/content_hash.hpp"

#include <xxhash.h>

#include <new>

namespace cloister {

ContentHash::ContentHash() : state_(XXH3_createState()) {
  if (state_ == nullptr) throw std::bad_alloc();
  reset();
}

void ContentHash::add(const void* bytes, std::size_t size) {
  XXH3_64bits_update(state_.get(), bytes, size);
}

std::uint64_t ContentHash::digest() const { return XXH3_64bits_digest(state_.get()); }

void ContentHash::reset() { XXH3_64bits_reset(state_.get()); }

void ContentHash::Free::operator()(XXH3_state_s* state) const { XXH3_freeState(state); }

}  // namespace cloister
