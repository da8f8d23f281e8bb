// tensor_mux and tensor_merge while branches are added and removed at random: no deadlock, and
// every lost buffer is counted.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "becomes.hpp"
#include "elements/tests/element_parts_test_support.hpp"

namespace weir::test {
namespace edit_test {

using gst::Ref;
using gst::Unique;

constexpr int kEdits = 12;
constexpr size_t kBranches = 5;  // at most

class Edited {
 public:
  explicit Edited(const std::string& element) {
    pipeline_ = test::lone_element(element + " name=mux ! tensor_sink name=out");
    mux_ = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "mux"));
  }
  ~Edited() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  Edited(const Edited&) = delete;
  Edited& operator=(const Edited&) = delete;

  void play() { gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING); }
  void stop() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  size_t branches() const { return branches_.size(); }

  void add(bool live) {
    const std::string launch = std::string("videotestsrc is-live=") + (live ? "true" : "false") +
                               " ! video/x-raw,format=GRAY8,width=4,height=4,framerate=1000/1 ! "
                               "tensor_converter ! queue max-size-buffers=2";
    Branch branch;
    branch.bin =
        Ref<GstElement>::share(gst_parse_bin_from_description(launch.c_str(), TRUE, nullptr));
    gst_bin_add(GST_BIN(pipeline_.get()), branch.bin.get());
    branch.pad = Ref<GstPad>::adopt(gst_element_request_pad_simple(mux_.get(), "sink_%u"));
    const auto out = Ref<GstPad>::adopt(gst_element_get_static_pad(branch.bin.get(), "src"));
    ASSERT_EQ(gst_pad_link(out.get(), branch.pad.get()), GST_PAD_LINK_OK);
    gst_element_sync_state_with_parent(branch.bin.get());
    branches_.push_back(std::move(branch));
  }
  void remove(size_t index) {
    Branch branch = branches_[index];
    branches_.erase(branches_.begin() + static_cast<std::ptrdiff_t>(index));
    gst_element_release_request_pad(mux_.get(), branch.pad.get());
    gst_element_set_locked_state(branch.bin.get(), TRUE);
    gst_element_set_state(branch.bin.get(), GST_STATE_NULL);
    gst_bin_remove(GST_BIN(pipeline_.get()), branch.bin.get());
  }
  uint64_t stat(const char* name) const { return test::stat(mux_.get(), name); }
  // Whether more output arrives after an edit.
  [[nodiscard]] bool more_come(uint64_t frames) const {
    const uint64_t until = stat("pushed") + frames;
    return becomes_true([&] { return stat("pushed") >= until || !error().empty(); },
                        [&] {
                          return std::to_string(until) + " frames pushed, with " +
                                 std::to_string(branches_.size()) + " branches; there are " +
                                 std::to_string(stat("pushed"));
                        });
  }
  // The first error of the element; branches whose pad was removed may post errors.
  const std::string& error() const {
    const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
    while (error_.empty()) {
      const Unique<GstMessage, gst_message_unref> message(
          gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
      if (!message) break;
      if (GST_MESSAGE_SRC(message.get()) != GST_OBJECT_CAST(mux_.get())) continue;
      error_ = test::get_text(message.get());
    }
    return error_;
  }

 private:
  struct Branch {
    Ref<GstElement> bin;
    Ref<GstPad> pad;
  };
  Ref<GstElement> pipeline_, mux_;
  std::vector<Branch> branches_;
  mutable std::string error_;
};

void edit(const std::string& element, unsigned seed) {
  SCOPED_TRACE(element + ", seed " + std::to_string(seed));
  std::mt19937 random(seed);
  Edited graph(element);
  graph.add(false);
  graph.play();
  ASSERT_TRUE(graph.more_come(1));
  for (int i = 0; i < kEdits; ++i) {
    const bool more = graph.branches() == 1 || (graph.branches() < kBranches && random() % 2 == 0);
    if (more)
      graph.add(random() % 3 == 0);
    else
      graph.remove(random() % graph.branches());
    if (random() % 4 != 0) {
      ASSERT_TRUE(graph.more_come(1 + random() % 3)) << "edit " << i;
    }
  }
  ASSERT_TRUE(graph.more_come(3));
  EXPECT_EQ(graph.error(), "");
  graph.stop();
  EXPECT_EQ(graph.stat("held"), 0u);
  EXPECT_EQ(graph.stat("received"), graph.stat("consumed") + graph.stat("dropped"));
  EXPECT_EQ(graph.stat("dropped-error"), 0u);
  EXPECT_EQ(graph.stat("dropped-eos"), 0u);
}

TEST(TensorMuxEdit, BranchesAreAddedAndRemovedInEachMode) {
  for (const char* mode : {"nosync", "slowest", "basepad", "refresh"})
    for (const unsigned seed : {1u, 2u, 3u})
      edit(std::string("tensor_mux sync-mode=") + mode, seed);
}

TEST(TensorMuxEdit, BranchesAreAddedAndRemovedWithMaxWait) {
  for (const unsigned seed : {4u, 5u}) edit("tensor_mux max-wait=5000000", seed);
}

TEST(TensorMuxEdit, BranchesOfAMergeAreAddedAndRemoved) {
  for (const unsigned seed : {6u, 7u, 8u}) edit("tensor_merge option=2", seed);
}

}  // namespace edit_test
}  // namespace weir::test
