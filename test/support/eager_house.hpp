#pragma once

#include <memory>
#include <utility>

#include <doctest/doctest.h>

#include "firmware_interface/mission/mission_reader.hpp"
#include "runtime/pipeline.hpp"

namespace cloister {

/// The house's mission, set so that many submaps begin and many are fused, and what a pipeline needs to map it.
struct EagerHouse {
  EagerHouse() {
    config.map.spawn.min_overlap = 0.85;
    config.map.spawn.max_travel_m = 2;
    auto opened = MissionReader::open(CLOISTER_HOUSE_MISSION, config.map);
    REQUIRE(opened.has_value());
    reader = std::move(*opened);
    options.max_scan_pixels = reader->max_pixels();
    options.max_scan_columns = reader->max_columns();
    scan.reserve(options.max_scan_pixels, options.max_scan_columns, MissionReader::kMaxPoses);
  }
  /// What comes next; a scan is in `scan`.
  MissionReader::Item next() {
    const auto item = reader->next(scan);
    REQUIRE(item.has_value());
    return *item;
  }
  /// Gives `scan` to a pipeline that has room for it.
  void submit_scan(Pipeline& pipeline) {
    Scan* slot = pipeline.try_take_slot();
    REQUIRE(slot != nullptr);
    std::swap(*slot, scan);
    pipeline.submit(slot);
  }

  ProgramConfig config;
  Pipeline::Options options;
  std::unique_ptr<MissionReader> reader;
  Scan scan;
};

}  // namespace cloister
