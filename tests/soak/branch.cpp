// Implements branches of a tee: adding, removing, counting.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "branch.hpp"

namespace weir::soak {
namespace {

uint64_t field(const GstStructure* stats, const char* name) {
  guint64 value = 0;
  gst_structure_get_uint64(stats, name, &value);
  return value;
}

// Returns "" or what is wrong with the counts of one element.
std::string check_ledger(GstElement* element, const uint64_t* frames) {
  GstStructure* raw = nullptr;
  g_object_get(element, "stats", &raw, nullptr);
  const gst::Unique<GstStructure, gst_structure_free> stats(raw);
  const uint64_t received = field(raw, "received"), consumed = field(raw, "consumed"),
                 dropped = field(raw, "dropped"), held = field(raw, "held");
  const uint64_t expected = (frames ? *frames : 0) * element->numsinkpads;
  const bool exact = !frames || (received == expected && consumed == expected && dropped == 0);
  if (exact && held == 0 && received == consumed + dropped) return "";
  const gst::UniqueText name{gst_element_get_name(element)};
  const gst::UniqueText text{gst_structure_to_string(raw)};
  return std::string(name.get()) + ": " + text.get() +
         (frames ? ", expected are " + std::to_string(*frames) + " frames" : "") + "\n";
}

bool counts_frames(GstElement* element) {
  const auto* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(element), "stats");
  const char* type = G_OBJECT_TYPE_NAME(element);
  return spec && g_str_has_prefix(type, "Weir");
}

}  // namespace

std::string check_ledgers(GstBin* bin, const uint64_t* frames) {
  std::string wrong;
  GstIterator* all = gst_bin_iterate_recurse(bin);
  GValue item = G_VALUE_INIT;
  while (gst_iterator_next(all, &item) == GST_ITERATOR_OK) {
    auto* element = GST_ELEMENT(g_value_get_object(&item));
    if (counts_frames(element)) wrong += check_ledger(element, frames);
    g_value_reset(&item);
  }
  g_value_unset(&item);
  gst_iterator_free(all);
  return wrong;
}

int Arrivals::read_number(GstBuffer* buffer) const {
  const gst::Mapped map(buffer, GST_MAP_READ);
  if (!map || map.bytes().empty()) return -1;
  const auto same = [this](const auto& values) {
    const int first = static_cast<int>(values.front());
    for (const auto value : values)
      if (static_cast<int>(value) != first) return -1;
    const int number = first - line_.offset;
    return number < kNumbers ? number : -1;
  };
  return line_.floats ? same(map.as<const float>()) : same(map.as<const uint8_t>());
}

void Arrivals::arrived(GstBuffer* buffer) {
  const int number = read_number(buffer);
  std::lock_guard lock(mutex_);
  ++frames_;
  const bool follows = last_ < 0 || number == (last_ + 1) % kNumbers;
  if (number < 0 || (line_.exact && !follows)) ++faults_;
  last_ = number;
  changed_.notify_all();
}

void Arrivals::ended() {
  std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

uint64_t Arrivals::frames() const {
  std::lock_guard lock(mutex_);
  return frames_;
}
uint64_t Arrivals::faults() const {
  std::lock_guard lock(mutex_);
  return faults_;
}
bool Arrivals::waits_for(uint64_t frames) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kPatience, [&] { return frames_ >= frames; });
}
bool Arrivals::waits_for_end() const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, kPatience, [&] { return ended_; });
}

Branch::Branch(GstElement* tee, const Line& line)
    : line_(line),
      pipeline_(Ref<GstElement>::adopt(GST_ELEMENT(gst_object_get_parent(GST_OBJECT(tee))))),
      tee_(Ref<GstElement>::share(tee)),
      bin_(Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(
          gst_parse_bin_from_description(line.launch.c_str(), TRUE, nullptr))))),
      arrivals_(std::make_unique<Arrivals>(line)) {
  const auto end = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(bin_.get()), "end"));
  g_object_set(end.get(), "async", FALSE, nullptr);
  g_signal_connect(end.get(), "new-data",
                   G_CALLBACK(+[](GstElement*, GstBuffer* b, Arrivals* a) { a->arrived(b); }),
                   arrivals_.get());
  g_signal_connect(end.get(), "eos", G_CALLBACK(+[](GstElement*, Arrivals* a) { a->ended(); }),
                   arrivals_.get());
  entry_ = Ref<GstPad>::adopt(gst_element_get_static_pad(bin_.get(), "sink"));
  // On the first element's own pad: a frame that passes here has entered the branch.
  const auto first = Ref<GstPad>::adopt(gst_ghost_pad_get_target(GST_GHOST_PAD(entry_.get())));
  gst_pad_add_probe(
      first.get(), GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad*, GstPadProbeInfo*, gpointer a) {
        static_cast<Arrivals*>(a)->entered();
        return GST_PAD_PROBE_OK;
      },
      arrivals_.get(), nullptr);
  gst_bin_add(GST_BIN(pipeline_.get()), bin_.get());
  gst_element_sync_state_with_parent(bin_.get());
  tee_pad_ = Ref<GstPad>::adopt(gst_element_request_pad_simple(tee, "src_%u"));
  gst_pad_link(tee_pad_.get(), entry_.get());
}

Branch::~Branch() {
  if (tee_pad_) remove(Removal::Abrupt);
}

std::string Branch::remove(Removal removal) {
  const bool rests = unlink_between_frames(tee_pad_.get(), entry_.get());
  if (!rests || (removal == Removal::Drained && !drains())) {
    tee_pad_ = {};
    arrivals_.release();  // a hanging thread still uses it
    return line_.launch + (rests ? ": EOS does not arrive\n" : ": the tee never rests\n");
  }
  gst_element_release_request_pad(tee_.get(), tee_pad_.get());
  tee_pad_ = {};
  gst_element_set_locked_state(bin_.get(), TRUE);
  gst_element_set_state(bin_.get(), GST_STATE_NULL);
  const std::string wrong = ledgers(removal);
  gst_bin_remove(GST_BIN(pipeline_.get()), bin_.get());
  return wrong.empty() ? "" : line_.launch + "\n" + wrong;
}

bool Branch::drains() {
  gst_pad_send_event(entry_.get(), gst_event_new_eos());
  return arrivals_->waits_for_end();
}

std::string Branch::ledgers(Removal removal) const {
  const uint64_t entered = arrivals_->entries();
  const bool exact = removal == Removal::Drained && line_.exact;
  std::string wrong = check_ledgers(GST_BIN(bin_.get()), exact ? &entered : nullptr);
  if (const auto faults = arrivals_->faults(); faults > 0)
    wrong += std::to_string(faults) + " frames damaged or out of place\n";
  if (exact && arrivals_->frames() != entered)
    wrong += std::to_string(entered) + " frames entered, " + std::to_string(arrivals_->frames()) +
             " arrived\n";
  return wrong;
}

}  // namespace weir::soak
