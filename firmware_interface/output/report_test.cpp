#include <filesystem>
#include <fstream>
#include <sstream>

#include <doctest/doctest.h>

#include "firmware_interface/output/mission_output.hpp"
#include "firmware_interface/output/page_text.hpp"
#include "firmware_interface/output/plan_svg.hpp"
#include "firmware_interface/output/report_html.hpp"
#include "firmware_interface/output/test_mission.hpp"

namespace cloister {
namespace {

// What is wrong with the nesting of a text's tags, or nothing: enough of XML for what we write.
std::string xml_fault(const std::string& text) {
  std::vector<std::string> open;
  for (std::size_t i = text.find('<'); i != std::string::npos; i = text.find('<', i + 1)) {
    const std::size_t end = text.find('>', i);
    if (end == std::string::npos) return "a tag without end";
    const std::string tag = text.substr(i + 1, end - i - 1);
    if (tag.find('<') != std::string::npos) return "a tag within a tag: " + tag;
    if (tag.front() == '!' || tag.back() == '/') continue;
    const bool is_closing = tag.front() == '/';
    const std::string name = tag.substr(is_closing, tag.find(' ') - is_closing);
    if (!is_closing) {
      open.push_back(name);
    } else if (open.empty() || open.back() != name) {
      return "</" + name + "> closes nothing";
    } else {
      open.pop_back();
    }
  }
  for (std::size_t i = text.find('&'); i != std::string::npos; i = text.find('&', i + 1)) {
    const std::string entity = text.substr(i, text.find(';', i) - i + 1);
    if (entity != "&amp;" && entity != "&lt;" && entity != "&gt;" && entity != "&quot;")
      return "a bare &";
  }
  return open.empty() ? "" : "<" + open.back() + "> is never closed";
}

std::string without_namespaces(std::string text) {
  for (const char* name :
       {"xmlns=\"http://www.w3.org/1999/xhtml\"", "xmlns=\"http://www.w3.org/2000/svg\""}) {
    for (std::size_t i; (i = text.find(name)) != std::string::npos;)
      text.erase(i, std::string(name).size());
  }
  return text;
}

void check_page(const std::string& page) {
  CHECK(xml_fault(page) == "");
  const std::string body = without_namespaces(page);
  for (const char* word : {"http", "url(", "<script", "@import", "src=", "href=", "nan", "inf\""}) {
    CAPTURE(word);
    CHECK(body.find(word) == std::string::npos);
  }
}

// A long walk over hills past walls of many colours, with more events than a page shows.
MissionRecord make_large_mission() {
  MissionRecord r = make_test_mission();
  r.submaps.clear();
  r.path_M.clear();
  r.timeline.resize(1);
  std::mt19937 random(17);
  const auto ground = [](double x, double y) { return 6.0 * std::sin(0.02 * x) + 0.03 * y; };
  for (int k = 0; k < 20'000; ++k) {
    const double turn = 0.0008 * k;
    const double x = 60 * std::cos(turn) + 20 * std::sin(7 * turn), y = 50 * std::sin(turn);
    const SensorTime stamp{k * 100'000'000LL};
    r.path_M.emplace_back(stamp,
                          make_pose({x, y, ground(x, y) + 1.3}, Eigen::Quaterniond::Identity()));
    TimelineRow row = r.timeline.front();
    row.stamp = stamp;
    row.map_bytes = 50'000LL * k;
    row.latency_ms = static_cast<float>(random() % 400) / 10.0f;
    r.timeline.push_back(row);
  }
  r.timeline.erase(r.timeline.begin());
  r.budget_bytes = 1'100'000'000;
  for (SubmapId id = 0; id < 400; ++id) {
    SubmapRecord submap;
    submap.id = id;
    for (int k = 0; k < 3'000; ++k) {
      const double x = (id % 20) * 8.0 - 80.0 + 0.01 * static_cast<double>(random() % 800);
      const double y = (id / 20) * 8.0 - 80.0 + 0.01 * static_cast<double>(random() % 800);
      const double height = random() % 3 == 0 ? 0.1 * static_cast<double>(random() % 40) : 0.0;
      submap.surface_M.emplace_back(static_cast<float>(x), static_cast<float>(y),
                                    static_cast<float>(ground(x, y) + height));
    }
    r.submaps.push_back(std::move(submap));
  }
  const std::vector<Event> few = r.events;
  for (int k = 0; k < 400; ++k) r.events.insert(r.events.end(), few.begin(), few.end());
  return r;
}

TEST_CASE("the report is well-formed and needs no network") {
  const MissionRecord record = make_test_mission();
  const std::string page = report_html(record);
  check_page(page);
  CHECK(page.find("two storeys &amp; &lt;six&gt; rooms") != std::string::npos);
  CHECK(page.find("Floor at 2.9 m") != std::string::npos);
  CHECK(page.find("0x00abcdef01234567") != std::string::npos);
  CHECK(page.find("name=\"viewport\"") != std::string::npos);
  CHECK(page.size() < 150'000);
}

TEST_CASE("the report of an empty mission is well-formed") {
  check_page(report_html(MissionRecord{}));
  CHECK(xml_fault(plan_svg(MissionRecord{})) == "");
}

TEST_CASE("the report of a single scan is well-formed") {
  MissionRecord record = make_test_mission();
  record.timeline.resize(1);
  record.path_M.resize(1);
  check_page(report_html(record));
}

TEST_CASE("a record full of numbers that are not finite gives a well-formed report") {
  MissionRecord record = make_test_mission();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (TimelineRow& row : record.timeline) row.integrate_ms = row.latency_ms = nan;
  for (auto& [stamp, T_M_L] : record.path_M) T_M_L.translation().setConstant(nan);
  for (SubmapRecord& submap : record.submaps) submap.aabb_min_M.setConstant(nan);
  record.submaps[0].surface_M.emplace_back(nan, nan, nan);
  record.travel_m = nan;
  check_page(report_html(record));
}

TEST_CASE("the report of a large mission stays small and says what it leaves out") {
  const MissionRecord record = make_large_mission();
  const std::string page = report_html(record);
  check_page(page);
  CHECK(page.size() < 2'000'000);
  CHECK(page.find("more in <code>events.jsonl</code>") != std::string::npos);
  CHECK(page.find("100 more in <code>submaps.json</code>") != std::string::npos);
  CHECK(page.find("Plan of each storey") == std::string::npos);
  CHECK(page.find(">budget</text>") != std::string::npos);
}

TEST_CASE("the plan is a picture of its own") {
  const std::string svg = plan_svg(make_test_mission());
  check_page(svg);
  CHECK(svg.rfind("<svg xmlns=", 0) == 0);
}

TEST_CASE("numbers for people are short and grouped") {
  CHECK(grouped(0) == "0");
  CHECK(grouped(-1'234) == "-1,234");
  CHECK(grouped(1'234'567) == "1,234,567");
  CHECK(compact(12.50) == "12.5");
  CHECK(compact(-0.001) == "0");
  CHECK(compact(100.0) == "100");
  CHECK(compact(std::nan("")) == "–");
  CHECK(readable(0.01234) == "0.0123");
  CHECK(readable(12.0) == "12.0");
  CHECK(readable(999.7) == "1,000");
  CHECK(byte_size(64'000'000) == "64.0 MB");
  CHECK(byte_size(1'073'741'824) == "1.07 GB");
  CHECK(clock_text(59.96, 1) == "1:00.0");
  CHECK(clock_text(9.94, 1) == "0:09.9");
  CHECK(clock_text(3'725) == "1:02:05");
  CHECK(clock_text(-5) == "-0:05");
}

TEST_CASE("text for pages is escaped, and bytes that are not UTF-8 are replaced") {
  CHECK(escape_xml("a<b>&\"c\"") == "a&lt;b&gt;&amp;&quot;c&quot;");
  CHECK(escape_xml("\x01ok\n") == " ok ");
  CHECK(escape_xml("é 中 😀") == "é 中 😀");
  CHECK(escape_xml("\xE9t") == "\xEF\xBF\xBDt");
  CHECK(escape_xml("\xED\xA0\x80") == "\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD");
}

struct TemporaryFolder {
  std::filesystem::path path = std::filesystem::temp_directory_path() /
                               ("cloister_report_test_" + std::to_string(std::random_device{}()));
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

TEST_CASE("a mission's outputs appear complete in a directory that did not exist") {
  const TemporaryFolder folder;
  REQUIRE(write_mission_outputs(make_test_mission(), folder.path / "deep" / "out").has_value());
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path / "deep" / "out")) {
    CHECK(entry.file_size() > 0);
    ++files;
  }
  CHECK(files == 7);
  for (const char* name : {"summary.json", "submaps.json", "timeline.csv", "events.jsonl",
                           "trajectory.tum", "plan.svg", "report.html"}) {
    CAPTURE(name);
    CHECK(std::filesystem::exists(folder.path / "deep" / "out" / name));
  }
}

TEST_CASE("an output that cannot be written is a resource error that names it") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path / "timeline.csv" / "in_the_way");
  const Result<void> blocked_file = write_mission_outputs(make_test_mission(), folder.path);
  REQUIRE_FALSE(blocked_file.has_value());
  CHECK(blocked_file.error().kind == ErrorKind::kResource);
  CHECK(blocked_file.error().message.find("timeline.csv") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder.path / "summary.json"));

  std::ofstream(folder.path / "file") << "not a directory";
  const Result<void> blocked_folder =
      write_mission_outputs(make_test_mission(), folder.path / "file" / "out");
  REQUIRE_FALSE(blocked_folder.has_value());
  CHECK(blocked_folder.error().kind == ErrorKind::kResource);
  CHECK(blocked_folder.error().message.find("file") != std::string::npos);
}

}  // namespace
}  // namespace cloister
