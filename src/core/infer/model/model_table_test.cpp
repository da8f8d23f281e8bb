// Tests which models are shared under a key.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/model_table.hpp"

#include <gtest/gtest.h>

#include "core/infer/model/sum_engine_test_support.hpp"
#include "says.hpp"

namespace weir::infer {
namespace model_table_test {

class ModelTableTest : public ::testing::Test {
 protected:
  ModelConfig source(const std::string& path) {
    ModelConfig out;
    out.engine = &engine_;
    out.options.paths = {path};
    return out;
  }

  sum_engine::Files files_;
  weir_engine engine_ = sum_engine::make_engine();
  ModelTable table_;
};

TEST_F(ModelTableTest, SharesTheSameModelUnderAKey) {
  const auto a = files_.write("a", "5 4");
  const auto first = table_.find("k", source(a)), second = table_.find("k", source(a));
  EXPECT_EQ(first.model, second.model);
  EXPECT_FALSE(second.not_shared);
  EXPECT_NE(table_.find("other", source(a)).model, first.model);
  EXPECT_NE(table_.find("", source(a)).model, table_.find("", source(a)).model);
  const auto slashes = a.substr(0, a.rfind('/')) + "/./" + a.substr(a.rfind('/') + 1);
  EXPECT_EQ(table_.find("k", source(slashes)).model, first.model)
      << "the same file, by another name";
}

TEST_F(ModelTableTest, DoesNotShareADifferentModelAndReportsWhy) {
  const auto a = files_.write("a", "5 4"), b = files_.write("b", "7 4");
  const auto first = table_.find("k", source(a)), second = table_.find("k", source(b));
  EXPECT_NE(first.model, second.model);
  ASSERT_TRUE(second.not_shared);
  EXPECT_EQ(second.not_shared->code, Code::MODEL_DIFFERS);
  EXPECT_SAYS(second.not_shared->message(), "offered: model=" + b);
  EXPECT_SAYS(second.not_shared->message(), "needed: shared-tensor-filter-key=k: model=" + a);
  auto other_options = source(a);
  other_options.options.options = {{"NumThreads", "2"}};
  EXPECT_TRUE(table_.find("k", other_options).not_shared);
  EXPECT_TRUE(ModelLease::create(second.model, 1));
}

TEST_F(ModelTableTest, ForgetsAModelWithItsLastUser) {
  const auto a = files_.write("a", "5 4"), b = files_.write("b", "7 4");
  table_.find("k", source(a)).model.reset();
  EXPECT_FALSE(table_.find("k", source(b)).not_shared);
}

}  // namespace model_table_test
}  // namespace weir::infer
