// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/analytics_meta.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"  // a flexible array
#include <gst/analytics/analytics.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "weir/results.h"

namespace weir::gst {
namespace {

using Meta = GstAnalyticsRelationMeta;
using Entry = GstAnalyticsMtd;

struct WholeBox {
  int x = 0, y = 0, width = 0, height = 0;
};

// Elements that scale pictures multiply these numbers by the sides of pictures, as int.
WholeBox around(const Box& box) {
  static constexpr double kMax = 1 << 16;
  const auto whole = [](double edge) { return static_cast<int>(std::clamp(edge, -kMax, kMax)); };
  const int x = whole(std::floor(box.x1)), y = whole(std::floor(box.y1));
  return {x, y, std::max(whole(std::ceil(box.x2)) - x, 0),
          std::max(whole(std::ceil(box.y2)) - y, 0)};
}

WholeBox to_whole_box(const Rect& at) {
  return {static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.width),
          static_cast<int>(at.height)};
}

Box box_of(double x, double y, double width, double height) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(x + width),
          static_cast<float>(y + height)};
}

std::string text(GQuark quark) {
  const char* label = g_quark_to_string(quark);
  return label ? label : "";
}

// ---- Reading ------------------------------------------------------------------------------------

class AnalyticsReader {
 public:
  AnalyticsReader(Meta* meta, std::vector<PictureRegion>* regions) : meta_(meta), out_(*regions) {}

  AnalyticsLeftOut read([[maybe_unused]] bool has_masks, [[maybe_unused]] ClassMap* class_map) {
    objects_ = entries(gst_analytics_od_mtd_get_mtd_type());
    labels_ = entries(gst_analytics_cls_mtd_get_mtd_type());
    tracks_ = entries(gst_analytics_tracking_mtd_get_mtd_type());
    read_objects();
    read_parents();
#if GST_CHECK_VERSION(1, 26, 0)
    read_segmentations(has_masks, class_map);
#endif
    left_out_.labels = labels_.size() - used_labels_.size();
    return left_out_;
  }

 private:
  std::vector<Entry> entries(GstAnalyticsMtdType type) {
    std::vector<Entry> out;
    gpointer state = nullptr;
    Entry entry{};
    while (gst_analytics_relation_meta_iterate(meta_, &state, type, &entry)) out.push_back(entry);
    return out;
  }

  bool has_relation(uint32_t from, uint32_t to, int types) const {
    return (gst_analytics_relation_meta_get_relation(meta_, from, to) & types) != 0;
  }
  // Those that have a relation to or from an entry: which of both elements write differs.
  std::vector<Entry> related(uint32_t id, const std::vector<Entry>& all) const {
    std::vector<Entry> out;
    for (const auto& entry : all)
      if (entry.id != id && (has_relation(id, entry.id, GST_ANALYTICS_REL_TYPE_ANY) ||
                             has_relation(entry.id, id, GST_ANALYTICS_REL_TYPE_ANY)))
        out.push_back(entry);
    return out;
  }

  void read_objects() {
    std::vector<bool> is_taken(out_.size());
    for (const auto& object : objects_) {
      auto read = read_object(object);
      size_t at = 0;
      while (at < is_taken.size() && (is_taken[at] || !is_same(out_[at], object.id, read))) ++at;
      if (at < is_taken.size()) {
        is_taken[at] = true;
        place_of_[object.id] = at;
        add_to(&out_[at], read);
      } else if (read.box.area() > 0 && read.score) {
        place_of_[object.id] = out_.size();
        out_.push_back(std::move(read));
      } else {
        ++left_out_.objects;
      }
    }
  }

  // Elements that scale pictures leave out the parameters of regions, and with them the id.
  static bool is_same(const PictureRegion& region, uint32_t id, const PictureRegion& object) {
    if (region.label != object.label) return false;
    if (region.analytics_id) return region.analytics_id == id;
    const auto near = [](float a, float b) { return std::abs(a - b) <= 1; };
    return near(region.box.x1, object.box.x1) && near(region.box.y1, object.box.y1) &&
           near(region.box.x2, object.box.x2) && near(region.box.y2, object.box.y2);
  }
  // What is not known of the region.
  static void add_to(PictureRegion* region, const PictureRegion& object) {
    if (region->track == 0) region->track = object.track;
    if (region->analytics_id) return;
    if (!region->score) region->score = object.score;
    if (region->rotation == 0) region->rotation = object.rotation;
  }

  PictureRegion read_object(Entry object) {
    PictureRegion out;
    int x = 0, y = 0, width = 0, height = 0;
    float score = 0;
#if GST_CHECK_VERSION(1, 26, 0)
    gst_analytics_od_mtd_get_oriented_location(&object, &x, &y, &width, &height, &out.rotation,
                                               &score);
    if (!std::isfinite(out.rotation)) out.rotation = 0;
#else
    gst_analytics_od_mtd_get_location(&object, &x, &y, &width, &height, &score);
#endif
    if (std::isfinite(score)) out.score = score;
    out.box = box_of(x, y, width, height);
    const GQuark type = gst_analytics_od_mtd_get_obj_type(&object);
    out.label = type ? text(type) : read_label(object.id);
    out.track = read_track(object.id);
    return out;
  }

  // The most probable class.
  std::string read_label(uint32_t object) {
    GQuark best = 0;
    float best_level = 0;
    for (auto& classes : related(object, labels_)) {
      used_labels_.insert(classes.id);
      for (gsize i = 0; i < gst_analytics_cls_mtd_get_length(&classes); ++i) {
        const float level = gst_analytics_cls_mtd_get_level(&classes, i);
        if (best != 0 && !(level > best_level)) continue;
        best = gst_analytics_cls_mtd_get_quark(&classes, i);
        best_level = level;
      }
    }
    return text(best);
  }

  // Columns of results have numbers from 1 on, up to a greatest one; 0 is no track there.
  uint32_t read_track(uint32_t object) {
    constexpr guint64 kMax = WEIR_RESULTS_TRACK_LIMIT - 1;
    for (auto& track : related(object, tracks_)) {
      guint64 id = 0;
      GstClockTime first = 0, last = 0;
      gboolean is_lost = FALSE;
      if (gst_analytics_tracking_mtd_get_info(&track, &id, &first, &last, &is_lost))
        return static_cast<uint32_t>(id == 0 ? kMax : (id - 1) % kMax + 1);
    }
    return 0;
  }

  void read_parents() {
    for (const auto& object : objects_)
      for (const auto& parent : objects_) {
        const auto place = place_of_.find(object.id), parent_place = place_of_.find(parent.id);
        const bool is_part =
            has_relation(object.id, parent.id, GST_ANALYTICS_REL_TYPE_IS_PART_OF) ||
            has_relation(parent.id, object.id, GST_ANALYTICS_REL_TYPE_CONTAIN);
        if (!is_part || object.id == parent.id || place == place_of_.end() ||
            parent_place == place_of_.end())
          continue;
        auto& region = out_[place->second];
        if (region.parent < 0) region.parent = static_cast<int32_t>(parent_place->second);
      }
  }

#if GST_CHECK_VERSION(1, 26, 0)
  void read_segmentations(bool has_masks, ClassMap* class_map) {
    for (const auto& entry : entries(gst_analytics_segmentation_mtd_get_mtd_type())) {
      const auto owners = related(entry.id, objects_);
      const bool is_used = owners.empty() ? class_map && read_class_map(entry, class_map)
                                          : has_masks && read_object_mask(entry, owners);
      left_out_.segmentations += is_used ? 0 : 1;
    }
  }

  // Which of its regions are whose is not known where several objects share a segmentation.
  bool read_object_mask(const Entry& entry, const std::vector<Entry>& owners) {
    const auto place = place_of_.find(owners[0].id);
    if (owners.size() > 1 || place == place_of_.end() || out_[place->second].mask.mask)
      return false;
    out_[place->second].mask = read_segmentation(entry);
    return true;
  }

  bool read_class_map(const Entry& entry, ClassMap* map) {
    if (!map->grid.numbers.empty()) return false;
    const auto found = read_segmentation(entry);
    map->grid = read_mask(found.mask.get());
    if (map->grid.numbers.empty()) return false;
    map->box = found.box;
    map->labels = read_region_labels(entry);
    return true;
  }

  static Segmentation read_segmentation(const Entry& entry) {
    Segmentation out;
    gint x = 0, y = 0;
    guint width = 0, height = 0;
    out.mask = Ref<GstBuffer>::adopt(
        gst_analytics_segmentation_mtd_get_mask(&entry, &x, &y, &width, &height));
    out.box = box_of(x, y, width, height);
    return out;
  }

  std::map<uint32_t, std::string> read_region_labels(const Entry& entry) {
    std::map<uint32_t, std::string> out;
    for (const auto& classes : related(entry.id, labels_)) {
      used_labels_.insert(classes.id);
      const gsize count = std::min(gst_analytics_segmentation_mtd_get_region_count(&entry),
                                   gst_analytics_cls_mtd_get_length(&classes));
      for (gsize i = 0; i < count; ++i)
        out[gst_analytics_segmentation_mtd_get_region_id(&entry, i)] =
            text(gst_analytics_cls_mtd_get_quark(&classes, i));
    }
    return out;
  }
#endif

  Meta* meta_;
  std::vector<PictureRegion>& out_;
  std::vector<Entry> objects_, labels_, tracks_;
  std::map<guint, size_t> place_of_;  // of each object
  std::set<guint> used_labels_;
  AnalyticsLeftOut left_out_;
};

}  // namespace

AnalyticsLeftOut read_analytics(GstBuffer* buffer, bool has_masks,
                                std::vector<PictureRegion>* regions, ClassMap* class_map) {
  Meta* meta = gst_buffer_get_analytics_relation_meta(buffer);
  return meta ? AnalyticsReader(meta, regions).read(has_masks, class_map) : AnalyticsLeftOut{};
}

// ---- Writing ------------------------------------------------------------------------------------

AnalyticsWriter::AnalyticsWriter(GstBuffer* buffer, const PictureResults& results)
    : meta_(gst_buffer_get_analytics_relation_meta(buffer)) {
  if (meta_) return;
  size_t entries = results.labels.size() + 2 * results.class_maps.size();
  for (const auto& region : results.regions)
    entries += 1 + (region.track > 0) + static_cast<bool>(region.mask.mask);
  // A small matrix would grow slowly, by as many entries each time.
  entries = std::clamp(entries, size_t{64}, kMaxEntries);
  GstAnalyticsRelationMetaInitParams sizes{entries, 64 * entries};
  meta_ = gst_buffer_add_analytics_relation_meta_full(buffer, &sizes);
}

bool AnalyticsWriter::has_room() {
  const bool has = gst_analytics_relation_get_length(meta_) < kMaxEntries;
  left_out_ += has ? 0 : 1;
  return has;
}

void AnalyticsWriter::relate(Object from, Object to, int types) {
  if (from && to)
    gst_analytics_relation_meta_set_relation(meta_, static_cast<GstAnalyticsRelTypes>(types), *from,
                                             *to);
}

AnalyticsWriter::Object AnalyticsWriter::add_object(const PictureRegion& region, const Rect& at,
                                                    Object parent) {
  if (!has_room()) return std::nullopt;
  const WholeBox box = region.rotation == 0 ? to_whole_box(at) : around(region.box);
  const GQuark type = make_quark(region.label);
  const float score = region.score.value_or(1);
  Entry object{};
#if GST_CHECK_VERSION(1, 26, 0)
  constexpr double kTurn = 2 * std::numbers::pi;
  const double angle = std::fmod(std::fmod(region.rotation, kTurn) + kTurn, kTurn);
  if (!gst_analytics_relation_meta_add_oriented_od_mtd(meta_, type, box.x, box.y, box.width,
                                                       box.height, static_cast<float>(angle), score,
                                                       &object))
    return std::nullopt;
#else
  if (!gst_analytics_relation_meta_add_od_mtd(meta_, type, box.x, box.y, box.width, box.height,
                                              score, &object))
    return std::nullopt;
#endif
  relate(object.id, parent, GST_ANALYTICS_REL_TYPE_IS_PART_OF);
  relate(parent, object.id, GST_ANALYTICS_REL_TYPE_CONTAIN);
  return object.id;
}

void AnalyticsWriter::add_track(Object object, uint32_t track, GstClockTime first_seen,
                                GstClockTime now) {
  Entry entry{};
  if (!has_room() || !object ||
      !gst_analytics_relation_meta_add_tracking_mtd(meta_, track, first_seen, &entry))
    return;
  gst_analytics_tracking_mtd_update_last_seen(&entry, now);
  relate(object, entry.id, GST_ANALYTICS_REL_TYPE_RELATE_TO);
}

AnalyticsWriter::Object AnalyticsWriter::add_classes(const std::vector<std::string>& labels,
                                                     float score) {
  if (!has_room()) return std::nullopt;
  std::vector<gfloat> levels(labels.size(), score);
  std::vector<GQuark> names;
  for (const auto& label : labels) names.push_back(make_quark(label));
  Entry entry{};
  if (!gst_analytics_relation_meta_add_cls_mtd(meta_, names.size(), levels.data(), names.data(),
                                               &entry))
    return std::nullopt;
  return entry.id;
}

void AnalyticsWriter::add_label(Object object, const std::string& label, float score) {
  if (object)
    relate(object, add_classes({label}, score), GST_ANALYTICS_REL_TYPE_RELATE_TO);
  else
    ++left_out_;
}

void AnalyticsWriter::add_picture_label(const std::string& label, float score) {
  add_classes({label}, score);
}

AnalyticsWriter::Object AnalyticsWriter::add_segmentation(
    [[maybe_unused]] const Segmentation& segmentation, [[maybe_unused]] const Box& part,
    [[maybe_unused]] bool is_of_object) {
#if GST_CHECK_VERSION(1, 26, 0)
  if (!has_room()) return std::nullopt;
  std::vector<guint> numbers;
  for (const auto& [number, label] : segmentation.labels) numbers.push_back(number);
  const WholeBox box = around(part);
  Entry entry{};
  if (gst_analytics_relation_meta_add_segmentation_mtd(
          meta_, Ref<GstBuffer>(segmentation.mask).release(),
          is_of_object ? GST_SEGMENTATION_TYPE_INSTANCE : GST_SEGMENTATION_TYPE_SEMANTIC,
          numbers.size(), numbers.data(), box.x, box.y, static_cast<guint>(box.width),
          static_cast<guint>(box.height), &entry))
    return entry.id;
#endif
  return std::nullopt;
}

void AnalyticsWriter::add_mask(Object object, const Segmentation& segmentation) {
  const Object mask = add_segmentation(segmentation, segmentation.box, true);
  relate(object, mask, GST_ANALYTICS_REL_TYPE_RELATE_TO);
  relate(mask, object, GST_ANALYTICS_REL_TYPE_RELATE_TO);
}

void AnalyticsWriter::add_class_map([[maybe_unused]] const Segmentation& map,
                                    [[maybe_unused]] const Box& box) {
#if GST_CHECK_VERSION(1, 26, 0)
  constexpr float kNotKnown = -1;
  std::vector<std::string> names;
  for (const auto& [number, label] : map.labels) names.push_back(label);
  const Object segmentation = add_segmentation(map, box, false);
  relate(segmentation, add_classes(names, kNotKnown),
         GST_ANALYTICS_REL_TYPE_RELATE_TO | GST_ANALYTICS_REL_TYPE_N_TO_N);
#endif
}

}  // namespace weir::gst
