#include "firmware_interface/ouster/ipv4_reassembler.hpp"

#include <algorithm>
#include <cstring>

namespace cloister {

Ipv4Reassembler::Ipv4Reassembler() {
  for (Slot& slot : slots_) slot.bytes.resize(kMaxBytes);
}

std::span<const std::byte> Ipv4Reassembler::add(const Ipv4Fragment& fragment) {
  const int size = static_cast<int>(std::min<std::size_t>(fragment.payload.size(), kMaxBytes));
  const int end = fragment.offset + size;
  // All but the last fragment fill whole units of eight bytes; anything else cannot be placed.
  if (size == 0 || end > kMaxBytes || (fragment.more && size % kUnitBytes != 0)) {
    ++malformed_fragments_;
    return {};
  }

  Slot& slot = slot_for(fragment);
  const int first_unit = fragment.offset / kUnitBytes;
  const int last_unit = (end - 1) / kUnitBytes;
  const auto count_held = [&slot, first_unit, last_unit] {
    int held = 0;
    for (int unit = first_unit; unit <= last_unit; ++unit) held += slot.held_units[unit] ? 1 : 0;
    return held;
  };
  const auto differs = [&slot, &fragment] {
    return std::memcmp(slot.bytes.data() + fragment.offset, fragment.payload.data(),
                       fragment.payload.size()) != 0;
  };
  int held = count_held();
  const int num_units = last_unit - first_unit + 1;
  const bool other_end =
      fragment.more ? slot.total_bytes != 0 && end >= slot.total_bytes
                    : slot.end_bytes > end || (slot.total_bytes != 0 && slot.total_bytes != end);
  const bool other_first = fragment.offset == 0 && held == num_units && differs();
  if (other_end || other_first || (held != 0 && held != num_units)) {
    give_up(slot);
    begin(slot, fragment);
    held = 0;
  }

  std::memcpy(slot.bytes.data() + fragment.offset, fragment.payload.data(),
              fragment.payload.size());
  if (held != 0) {
    ++repeated_fragments_;
  } else {
    for (int unit = first_unit; unit <= last_unit; ++unit) slot.held_units.set(unit);
    slot.held_bytes += size;
    slot.end_bytes = std::max(slot.end_bytes, end);
  }
  if (!fragment.more) slot.total_bytes = end;
  if (slot.total_bytes == 0 || slot.held_bytes != slot.total_bytes) return {};
  slot.in_use = false;
  return {slot.bytes.data(), static_cast<std::size_t>(slot.total_bytes)};
}

Ipv4Reassembler::Slot& Ipv4Reassembler::slot_for(const Ipv4Fragment& fragment) {
  Slot* chosen = nullptr;
  for (Slot& slot : slots_) {
    if (slot.in_use && slot.id == fragment.id && slot.source_address == fragment.source_address &&
        slot.destination_address == fragment.destination_address) {
      const std::int64_t age_ns = fragment.capture_time_ns - slot.begun_ns;
      if (age_ns <= kMaxAgeNs && age_ns >= -kMaxAgeNs) return slot;
      chosen = &slot;
      break;
    }
    // A free slot before any used one, then the one begun first.
    if (chosen == nullptr || (chosen->in_use && (!slot.in_use || slot.order < chosen->order))) {
      chosen = &slot;
    }
  }
  if (chosen->in_use) give_up(*chosen);
  begin(*chosen, fragment);
  return *chosen;
}

void Ipv4Reassembler::begin(Slot& slot, const Ipv4Fragment& fragment) {
  slot.in_use = true;
  slot.source_address = fragment.source_address;
  slot.destination_address = fragment.destination_address;
  slot.id = fragment.id;
  slot.begun_ns = fragment.capture_time_ns;
  slot.order = ++order_;
  slot.total_bytes = 0;
  slot.held_bytes = 0;
  slot.end_bytes = 0;
  slot.held_units.reset();
}

void Ipv4Reassembler::give_up(Slot& slot) {
  slot.in_use = false;
  ++incomplete_datagrams_;
}

void Ipv4Reassembler::clear() {
  for (Slot& slot : slots_) {
    if (slot.in_use) give_up(slot);
  }
}

}  // namespace cloister
