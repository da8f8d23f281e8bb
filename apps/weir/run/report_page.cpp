// Writes the tables and pictures of a run in the order of questions: what, where, how fast, why.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/report_document.hpp"

#include <algorithm>

#include "core/config/install_paths.hpp"
#include "core/trace/graph_layout.hpp"
#include "run/html.hpp"
#include "run/ledger_table.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

constexpr double kWidth = 640, kHeight = 150, kLeft = 54, kTop = 10, kBottom = 24;

std::string number(double value) {
  return fixed(value, 1);
}

std::string label(double x, double y, const char* anchor, const std::string& text) {
  return "<text class=\"axis\" text-anchor=\"" + std::string(anchor) + "\" x=\"" + number(x) +
         "\" y=\"" + number(y) + "\">" + escaped(text) + "</text>";
}

std::string frame(const char* kind, const std::string& inside) {
  const double bottom = kTop + kHeight;
  return "<svg class=\"" + std::string(kind) + "\" role=\"img\" width=\"" +
         number(kLeft + kWidth + 40) + "\" height=\"" + number(bottom + kBottom) +
         "\" viewBox=\"0 0 " + number(kLeft + kWidth + 40) + " " + number(bottom + kBottom) +
         "\"><path class=\"grid\" d=\"M" + number(kLeft) + "," + number(kTop) + " V" +
         number(bottom) + " H" + number(kLeft + kWidth) + "\"/>" + inside + "</svg>\n";
}

// `queue`: an item of summary["queues"]; `seconds`: the duration of the run.
std::string level_chart(const Json& queue, double seconds) {
  const Json& levels = queue["levels"];
  const double max = std::max(queue["most"].get<double>(), 1.0);
  const double step = kWidth / static_cast<double>(std::max<size_t>(levels.size(), 1));
  const double bottom = kTop + kHeight;
  std::string path = "M" + number(kLeft) + "," + number(bottom);
  double x = kLeft;
  for (const Json& level : levels) {
    path += " V" + number(bottom - level.get<double>() / max * kHeight);
    x += step;
    path += " H" + number(x);
  }
  path += " V" + number(bottom) + " z";
  return frame("levels", "<path class=\"area\" d=\"" + path + "\"/>" +
                             label(kLeft - 6, kTop + 8, "end", fixed(max, 0)) +
                             label(kLeft - 6, bottom, "end", "0") +
                             label(kLeft, bottom + 17, "start", "0 s") +
                             label(kLeft + kWidth, bottom + 17, "end", fixed(seconds, 2) + " s"));
}

// `latency`: an item of summary["latencies"] with frames.
std::string histogram(const Json& latency) {
  const Json& buckets = latency["buckets"];
  double max = 1;
  for (const Json& bucket : buckets) max = std::max(max, bucket["frames"].get<double>());
  const auto count = static_cast<double>(std::max<size_t>(buckets.size(), 1));
  const double step = std::min(kWidth / count, 60.0), bottom = kTop + kHeight;
  std::string inside =
      label(kLeft - 6, kTop + 8, "end", fixed(max, 0)) + label(kLeft - 6, bottom, "end", "0");
  double x = kLeft;
  const size_t labelled = buckets.size() / 8 + 1;
  for (size_t i = 0; i < buckets.size(); ++i, x += step) {
    const Json& bucket = buckets[i];
    const double height = bucket["frames"].get<double>() / max * kHeight;
    const std::string range = duration_text(bucket["from"]) + " to " + duration_text(bucket["to"]);
    inside += "<rect class=\"bar\" x=\"" + number(x + 1) + "\" y=\"" + number(bottom - height) +
              "\" width=\"" + number(std::max(step - 2, 1.0)) + "\" height=\"" + number(height) +
              "\"><title>" + escaped(range) + ": " + fixed(bucket["frames"], 0) +
              " frames</title></rect>";
    if (i % labelled == 0) inside += label(x, bottom + 17, "start", duration_text(bucket["from"]));
  }
  return frame("histogram", inside);
}

using Rows = std::vector<std::vector<std::string>>;

std::string count(const Json& value) {
  return fixed(value, 0);
}

std::string get_name(const Json& summary, const Json& element) {
  return element.is_number() ? summary["elements"][element.get<size_t>()]["name"].get<std::string>()
                             : std::string();
}

// The elements in the pipeline except bins, in stream order; without those that a bin tried out and
// removed before a frame came.
std::vector<size_t> shown_elements(const Json& summary) {
  std::vector<size_t> out;
  for (size_t i = 0; i < summary["elements"].size(); ++i) {
    const Json& element = summary["elements"][i];
    const bool is_used = element["in"]["frames"] > 0 || element["out"]["frames"] > 0;
    if (!element["bin"] && !element["parent"].is_null() && (is_used || !element["removed"]))
      out.push_back(i);
  }
  std::vector<std::pair<size_t, size_t>> arrows;
  for (const Json& link : summary["links"])
    if (link["from"].is_number() && link["to"].is_number())
      arrows.emplace_back(link["from"], link["to"]);
  const auto places = trace::lay_out(summary["elements"].size(), arrows).boxes;
  std::stable_sort(out.begin(), out.end(), [&places](size_t a, size_t b) {
    return std::pair(places[a].column, places[a].row) < std::pair(places[b].column, places[b].row);
  });
  return out;
}

std::string drops(const Json& stats) {
  constexpr std::string_view kPrefix = "dropped-";
  std::vector<std::string> out;
  for (const auto& [name, value] : stats.items())
    if (name.starts_with(kPrefix) && value.is_number() && value != 0)
      out.push_back(name.substr(kPrefix.size()) + " " + count(value));
  return join(out, ", ");
}

std::string diagnostics(const Json& list, const char* kind) {
  std::string out;
  for (const Json& item : list) {
    out += "<li><b class=\"bad\">" + std::string(kind) + "</b> ";
    if (item.value("element", "") != "") out += escaped(item.value("element", "")) + ": ";
    out += escaped(item.value("id", "")) + " " + escaped(item.value("what", ""));
    for (const char* part : {"offered", "needed", "difference", "fix", "debug"})
      if (item.value(part, "") != "" &&
          (part != std::string("debug") || item.value("id", "") == ""))
        out += "<br>" + std::string(part) + ": " + escaped(item.value(part, ""));
    out += "</li>\n";
  }
  return out;
}

// "camera: Intel Core i5, 4 cores, 8.00 GB; Linux 6.1 x86_64; weir 3.0.0, GStreamer 1.22.0,
// onnxruntime 1.20.1; 2026-11-26T18:00:00Z".
std::string host_line(const Json& document) {
  const Json &host = document["host"], &versions = document["versions"];
  std::string out = host["name"].get<std::string>() + ": " + host["processor"].get<std::string>() +
                    ", " + count(host["cores"]) + " cores, " + bytes_text(host["memory_bytes"]);
  for (const Json& gpu : host["gpus"]) out += ", " + gpu.get<std::string>();
  out += "; " + host["system"].get<std::string>() + "; weir " +
         versions["weir"].get<std::string>() + ", GStreamer " +
         versions["gstreamer"].get<std::string>();
  for (const auto& [engine, version] : versions["engines"].items())
    out += ", " + engine + " " + version.get<std::string>();
  out += "; " + host["time"].get<std::string>();
  return "<p class=\"note\" id=\"host\">" + escaped(out) + "</p>\n";
}

std::string result_text(const Json& outcome) {
  const std::string result = outcome["result"];
  const std::string unit = outcome["frames"] != 0 ? "frames" : "buffers";
  const std::string verb = result == "eos"          ? "Ended"
                           : result == "error"      ? "Failed"
                           : result == "time-limit" ? "Stopped by --timeout"
                                                    : "Interrupted";
  if (outcome["seconds_to_start"] == 0) return verb + " without a frame";
  return verb + " " + fixed(outcome["seconds"], 3) +
         " s after the first frame: " + count(outcome[unit]) + " " + unit + ", " +
         fixed(outcome["frame_rate"], 1) + " " + unit + "/s";
}

std::string head(const Json& document) {
  const Json &outcome = document["outcome"], &verdict = document["verdict"];
  std::string out = "<h1>Pipeline report</h1>\n<p id=\"verdict\" class=\"" +
                    verdict["kind"].get<std::string>() + "\">" +
                    escaped(verdict["text"].get<std::string>()) + "</p>\n<p id=\"result\">" +
                    result_text(outcome);
  if (const Json& lost = document["trace"]["lost"]; lost != 0)
    out += ". <b class=\"bad\">The logs were full: " + count(lost) +
           " records are missing, so figures below are too small.</b>";
  out += "</p>\n";
  const std::string entries =
      diagnostics(outcome["errors"], "error") + diagnostics(outcome["warnings"], "warning");
  if (!entries.empty()) out += "<ul class=\"diagnostics\">" + entries + "</ul>\n";
  return out + "<pre id=\"pipeline\">" + escaped(document["pipeline"].get<std::string>()) +
         "</pre>\n" + host_line(document);
}

std::vector<std::string> element_row(const Json& element) {
  const double in = element["in"]["frames"], out = element["out"]["frames"];
  const double work = element["work"].get<double>() + element["thread_work"].get<double>();
  const Json stats = element.value("stats", Json::object());
  const auto stat = [&stats](const char* name) {
    return stats.contains(name) ? count(stats[name]) : std::string();
  };
  const auto share = [&element](const char* name) {
    const double value = element[name];
    return value > 0 ? fixed(value * 100, 1) + " %" : std::string();
  };
  return {escaped(element["name"].get<std::string>()),
          escaped(element["factory"].get<std::string>()),
          count(element["in"]["frames"]),
          count(element["out"]["frames"]),
          element["refused"] > 0 ? count(element["refused"]) : "",
          rate_text(in > 0 ? element["in"]["rate"] : element["out"]["rate"]),
          share("share"),
          share("waiting_share"),
          work > 0 ? duration_text(work / std::max({in, out, 1.0})) : "",
          in > 0 ? duration_text(element["longest"]) : "",
          duration_text(element["states"].get<double>() + element["events"].get<double>()),
          stat("bytes-copied"),
          stat("dropped"),
          drops(stats)};
}

// Without the columns that are empty in every row; `texts` are the columns of text.
std::string compact_table(Rows rows, std::string_view id, std::vector<size_t> texts) {
  for (size_t c = rows[0].size(); c-- > 0;) {
    const bool is_empty =
        std::all_of(rows.begin() + 1, rows.end(), [c](const auto& row) { return row[c].empty(); });
    if (!is_empty) continue;
    for (auto& row : rows) row.erase(row.begin() + static_cast<std::ptrdiff_t>(c));
    std::erase(texts, c);
    for (size_t& text : texts) text -= text > c ? 1 : 0;
  }
  return html_table(rows, id, texts);
}

std::string elements(const Json& trace, const std::vector<size_t>& shown) {
  Rows rows{{"element", "is a", "frames in", "out", "refused", "frames/s", "work", "waiting",
             "a frame", "longest", "start, events", "bytes copied", "dropped", "why"}};
  for (const size_t i : shown) rows.push_back(element_row(trace["elements"][i]));
  return "<h2>Elements</h2>\n" + compact_table(std::move(rows), "elements", {1, 13}) +
         "<p class=\"note\">Work and waiting are shares of the time in which frames flowed, "
         "without "
         "that of downstream elements. A sink or a live source waits for the clock, a queue for a "
         "frame or for space, an element of several inputs for the others. Elements in threads of "
         "their own work at the same time, so the sum can be more than 100 %. A frame: the work "
         "for each. Copied and dropped come from the ledger of Weir's elements.</p>\n";
}

std::string properties(const Json& trace, const std::vector<size_t>& shown) {
  Rows rows{{"element", "property", "value"}};
  for (const size_t i : shown)
    for (const auto& [name, value] : trace["elements"][i]["properties"].items())
      rows.push_back(
          {escaped(get_name(trace, Json(i))), escaped(name), escaped(value.get<std::string>())});
  if (rows.size() == 1) return "";
  return "<details><summary>Properties that are not at their default</summary>\n" +
         html_table(rows, "properties", {1, 2}) + "</details>\n";
}

// The inference servers of filters; "" if there are none.
std::string servers(const Json& outcome) {
  Rows rows = server_rows(outcome["ledger"]);
  if (rows.empty()) return "";
  for (auto& row : rows)
    for (auto& cell : row) cell = escaped(cell);
  return "<h2>Servers</h2>\n" + html_table(rows, "servers", {0, 1, 7});
}

std::string caps_cell(const Json& link) {
  const std::string caps = link["caps"];
  const int changes = link["caps_changes"];
  return escaped(caps) + (changes == 0 ? "" : " (the last of " + std::to_string(changes + 1) + ")");
}

std::string links(const Json& summary) {
  Rows rows{{"from", "to", "frames", "frames/s", "bytes", "bytes/s", "caps"}};
  const auto end = [&](const Json& link, const char* element, const char* pad) {
    return escaped(get_name(summary, link[element]) + "." + link[pad].get<std::string>());
  };
  for (const Json& link : summary["links"]) {
    const double frames = link["frames"], rate = link["rate"], bytes = link["bytes"];
    rows.push_back({end(link, "from", "from_pad"), end(link, "to", "to_pad"), count(link["frames"]),
                    rate_text(rate), bytes_text(bytes),
                    rate > 0 ? bytes_text(bytes / frames * rate) : "", caps_cell(link)});
  }
  return "<h2>Links</h2>\n" + html_table(rows, "links", {1, 6});
}

std::string queues(const Json& summary) {
  if (summary["queues"].empty()) return "";
  Rows rows{{"queue", "most frames", "mean", "fullest", "not passed on"}};
  std::string charts;
  for (const Json& queue : summary["queues"]) {
    const std::string name = escaped(get_name(summary, queue["element"]));
    rows.push_back({name, count(queue["most"]), fixed(queue["mean"], 2),
                    fixed(queue["fullest"].get<double>() * 100, 0) + " %",
                    count(queue["not_passed_on"])});
    charts += "<h3>" + name + "</h3>\n" + level_chart(queue, summary["seconds"]);
  }
  return "<h2>Queues</h2>\n" + html_table(rows, "queues") +
         "<p class=\"note\">Fullest is the highest level relative to the limit in frames, bytes or "
         "time. "
         "Not passed on: leaked, flushed, or still in the queue at the end. The charts show the "
         "frames "
         "in the queue over time.</p>\n" +
         charts;
}

std::string latencies(const Json& summary) {
  Rows rows{
      {"from", "to", "frames", "least", "median", "mean", "95 %", "99 %", "most", "not matched"}};
  std::string charts;
  for (const Json& item : summary["latencies"]) {
    std::string from = get_name(summary, item["source"]);
    if (item["origin"] != item["source"])
      from = get_name(summary, item["origin"]) + "." + item["origin_pad"].get<std::string>() +
             " (of " + from + ")";
    from = escaped(from);
    const std::string to = escaped(get_name(summary, item["sink"]));
    std::vector<std::string> row{from, to, count(item["frames"])};
    for (const char* name : {"least", "median", "mean", "percentile_95", "percentile_99", "most"})
      row.push_back(item["frames"] > 0 ? duration_text(item[name]) : "");
    row.push_back(count(item["unmatched"]));
    rows.push_back(std::move(row));
    if (item["frames"] > 0)
      charts.append("<h3>").append(from).append(" to ").append(to).append("</h3>\n").append(
          histogram(item));
  }
  if (rows.size() == 1) return "";
  return "<h2>Latency</h2>\n" + html_table(rows, "latencies", {1}) +
         "<p class=\"note\">From the push to the arrival of a frame with the same timestamp at "
         "the sink. A "
         "file has no timestamps before its demuxer or parser: latency counts from there. The "
         "charts show the number of frames for each latency, with steps that grow "
         "with the latency.</p>\n" +
         charts;
}

}  // namespace

std::string report_page(const Json& document) {
  const Json& trace = document["trace"];
  const auto shown = shown_elements(trace);
  std::string out = page_begin("Pipeline report") + head(document) + "<h2>Graph</h2>\n" +
                    graph_picture(trace, shown, document["verdict"]["element"]);
  if (const double seconds = trace["flow_seconds"]; seconds > 0)
    out +=
        "<p class=\"note\"><span class=\"key work\"></span> work and <span class=\"key "
        "waiting\"></span> waiting, as shares of " +
        fixed(seconds, 3) +
        " s in which frames flowed. Point at a box for its properties, at an arrow for its "
        "caps.</p>\n";
  out += elements(trace, shown) + servers(document["outcome"]) + links(trace) + queues(trace) +
         latencies(trace) + properties(trace, shown);
  return out + "<p class=\"note\">Written by weir " + config::kVersion + " run --report; " +
         count(trace["records"]) + " records in " + fixed(trace["seconds"], 3) +
         " s.</p>\n</body></html>\n";
}

}  // namespace weir::app
