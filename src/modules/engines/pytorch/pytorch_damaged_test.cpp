// Tests damaged TorchScript archives: none crashes or hangs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "damaged_model_test_support.hpp"
#include "pytorch/torchscript_builder_test_support.hpp"

namespace weir::engine_test {
namespace pytorch_damaged_test {

class PytorchDamaged : public EngineTest {};

const OpenEngine::Options kFour{{"input", "4"}, {"inputtype", "float32"}};

TEST_F(PytorchDamaged, VersionsOfASmallModelAreRejectedOrRun) {
  const auto whole = torchscript(
      "def forward(self, x: Tensor) -> Tuple[Tensor, Tensor]:\n"
      "  y = torch.add(torch.mul(x, 3), 1)\n"
      "  return (y, torch.relu(y))");
  const auto counts = run_damaged(*engine(), whole, folder_, kFour);
  EXPECT_EQ(counts.refused + counts.failed + counts.ran + counts.large, kDamagedVersions);
  EXPECT_GT(counts.refused, kDamagedVersions / 3) << "what was cut, at least";
}

TEST_F(PytorchDamaged, VersionsOfARealModelAreRejectedOrRun) {
  const auto path = shared_file("models/torchscript/pytorch_lenet5.pt");
  if (path.empty()) GTEST_SKIP() << "../shared/models/torchscript is not there";
  const auto counts = run_damaged(*engine(), read_bytes(path), folder_,
                                  {{"input", "1:28:28:1"}, {"inputtype", "uint8"}});
  EXPECT_GT(counts.refused, kDamagedVersions / 3) << "what was cut, and what has checksums";
}

}  // namespace pytorch_damaged_test
}  // namespace weir::engine_test
