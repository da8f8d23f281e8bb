// EditedPipeline: a pipeline that is edited at random while it plays. Branches come and go, a valve
// opens and closes, selectors switch, caps change, it pauses. The same seed gives the same edits.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/app/gstappsrc.h>
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "branch.hpp"
#include "request_pads.hpp"

namespace weir::soak {

class EditedPipeline {
 public:
  // `model`: any file; the engine `fake` accepts it.
  EditedPipeline(uint32_t seed, const std::string& model);
  EditedPipeline(const EditedPipeline&) = delete;
  EditedPipeline& operator=(const EditedPipeline&) = delete;
  ~EditedPipeline();

  // Makes one edit, then waits for frames at the branch that never changes. Returns what is wrong,
  // with the seed, or "".
  std::string edit();
  // Sends EOS through the whole pipeline, then checks every ledger.
  std::string finish();

  uint64_t frames() const { return fed_; }
  uint64_t lost() const { return lost_; }  // frames lost where no policy drops any
  uint64_t edits() const { return edits_; }

 private:
  static void feed(GstAppSrc* source, guint, gpointer self);
  void add_branch();
  std::string remove_branch(Removal removal);
  std::string pause();
  std::string edit_pads(RequestPads& pads);
  Ref<GstElement> find(const char* name) const;
  Ref<GstPad> pad(const char* element, const char* name) const;
  void watch(const char* sink, Arrivals* arrivals);
  std::string change();
  std::string bus_error() const;
  int any(int below) { return static_cast<int>(random_() % static_cast<uint32_t>(below)); }

  const uint32_t seed_;
  std::mt19937 random_;
  std::vector<Line> lines_;
  std::atomic<int> width_{8};
  std::atomic<bool> over_{false};
  std::atomic<uint64_t> fed_{0};
  uint64_t lost_ = 0, edits_ = 0;
  Arrivals muxed_, joined_;
  Ref<GstElement> pipeline_, tee_;
  std::unique_ptr<Branch> always_;
  std::vector<std::unique_ptr<Branch>> branches_;
  std::unique_ptr<RequestPads> mux_pads_, join_pads_;
};

}  // namespace weir::soak
