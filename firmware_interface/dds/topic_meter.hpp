#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware_interface/dds/dds_link.hpp"
#include "mapping/core/result.hpp"

namespace cloister {

/// Counts what is sent on Cloister's own topics, and finds which others there are. Threads: one at a time.
class TopicMeter {
 public:
  struct Row {
    std::string topic;
    std::string type;
    bool is_measured = false;  ///< one of Cloister's own: the numbers below count
    std::uint64_t count = 0;
    std::uint64_t bytes = 0;  ///< as serialised
  };

  [[nodiscard]] static Result<TopicMeter> open(const DdsLink& link);
  TopicMeter(TopicMeter&&) noexcept;
  TopicMeter& operator=(TopicMeter&&) noexcept;
  ~TopicMeter();

  /// Waits, and counts what has arrived.
  void poll(std::chrono::milliseconds timeout);
  /// Topics that somebody publishes, by name.
  [[nodiscard]] std::vector<Row> rows() const;

 private:
  struct Ends;
  explicit TopicMeter(std::unique_ptr<Ends> ends);
  std::unique_ptr<Ends> ends_;
};

}  // namespace cloister
