// Properties with syntax errors: the message gives the position, and the element works once they
// are corrected.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tests/bad_input_bench_test_support.hpp"

namespace bad_properties_test {

using namespace weir::testing_bad_input;

struct Typo {
  const char *name, *line, *caps;
  std::vector<const char*> messages;
};
void PrintTo(const Typo& typo, std::ostream* out) {
  *out << typo.line;
}

class PropertyTypo : public testing::TestWithParam<Typo> {};

TEST_P(PropertyTypo, IsReportedWithItsPosition) {
  Bench bench(GetParam().line);
  const std::string error = bench.start(GetParam().caps);
  for (const char* message : GetParam().messages) EXPECT_SAYS(error, message);
  bench.expect_balance(0);
}

constexpr char kBytes[] = "application/octet-stream,framerate=30/1";
constexpr char kTensor[] =
    "other/tensors,format=(string)static,num_tensors=1,dimensions=(string)4:4,"
    "types=(string)uint8,framerate=30/1";
constexpr char kRows[] =
    "other/tensors,format=(string)static,num_tensors=1,dimensions=(string)6:1,"
    "types=(string)float32,framerate=30/1";
constexpr char kVideo[] = "video/x-raw,format=RGB,width=8,height=4,framerate=30/1";

INSTANTIATE_TEST_SUITE_P(
    All, PropertyTypo,
    testing::Values(
        Typo{"dimension",
             "tensor_converter input-dim=3:x:2 input-type=uint8",
             kBytes,
             {"WEIR-1002", "3:x:2"}},
        Typo{"type",
             "tensor_converter input-dim=3 input-type=unit8",
             kBytes,
             {"WEIR-1003", "unit8", "uint8"}},
        Typo{"lists",
             "tensor_converter input-dim=3,4 input-type=uint8",
             kBytes,
             {"WEIR-1004", "differ in number"}},
        Typo{"mode", "tensor_converter mode=custom-cod:x", kBytes, {"WEIR-1005", "custom-cod:x"}},
        Typo{"script",
             "tensor_converter mode=custom-script:/nonexistent.py",
             kBytes,
             {"WEIR-", "nonexistent.py"}},
        Typo{"operator",
             "tensor_transform mode=arithmetic option=ad:1",
             kTensor,
             {"WEIR-1001", "ad:1", "^"}},
        Typo{"number",
             "tensor_transform mode=arithmetic option=add:1x",
             kTensor,
             {"WEIR-1001", "add:1x", "^"}},
        Typo{"cast",
             "tensor_transform mode=typecast option=float33",
             kTensor,
             {"WEIR-1", "float33"}},
        Typo{"permutation",
             "tensor_transform mode=transpose option=1:1:2:3",
             kTensor,
             {"WEIR-1", "1:1:2:3"}},
        Typo{"scores",
             "tensor_tracker low=0.6 high=0.25",
             kRows,
             {"WEIR-1004", "low=0.6 high=0.25", "fix: tensor_tracker low=0.25 high=0.6"}},
        Typo{"range", "tensor_transform mode=clamp option=5:1", kTensor, {"WEIR-1", "5:1"}},
        Typo{"choice",
             "tensor_transform mode=clamp option=1:5 apply=0,x",
             kTensor,
             {"WEIR-1001", "apply cannot be read", "x"}},
        Typo{"mean", "tensor_preprocess width=4 height=4 mean=1,x,3", kVideo, {"WEIR-1", "1,x,3"}},
        Typo{"sizes", "tensor_preprocess sizes=4x4,4y4", kVideo, {"WEIR-1", "4y4"}},
        Typo{
            "pixels", "tensor_preprocess width=4 height=4 type=uint9", kVideo, {"WEIR-1", "uint9"}},
        Typo{"scale",
             "tensor_preprocess width=4 height=4 type=int8 quantisation=0.5",
             kVideo,
             {"WEIR-1", "0.5"}},
        Typo{"card",
             "tensor_preprocess card=/nonexistent.card.json",
             kVideo,
             {"WEIR-", "nonexistent.card.json"}},
        Typo{"decoder",
             "tensor_decoder mode=image_labelling",
             kTensor,
             {"WEIR-3010", "did you mean image_labeling?"}},
        Typo{"labels",
             "tensor_decoder mode=image_labeling option1=/nonexistent.txt",
             kTensor,
             {"WEIR-4001", "nonexistent.txt"}},
        Typo{"segmentation",
             "tensor_decoder mode=image_segment option1=snpe-deplab",
             kTensor,
             {"WEIR-1004", "did you mean snpe-deeplab?"}},
        Typo{"key_points",
             "tensor_decoder mode=pose_estimation option1=4:4 option2=2:2 "
             "option3=/nonexistent.txt",
             kTensor,
             {"WEIR-4001", "nonexistent.txt", "No such file"}},
        Typo{"regions",
             "tensor_decoder mode=tensor_region option1=zero",
             kTensor,
             {"WEIR-1001: option1 is not a number of regions"}},
        Typo{"overlay_labels",
             "tensor_overlay labels=/nonexistent.txt",
             kVideo,
             {"WEIR-4001", "nonexistent.txt"}},
        Typo{"to_roi_labels",
             "tensor_to_roi labels=/nonexistent.txt",
             kVideo,
             {"WEIR-4001", "nonexistent.txt"}},
        Typo{"from_roi_labels",
             "tensor_from_roi labels=/nonexistent.txt",
             kVideo,
             {"WEIR-4001", "nonexistent.txt"}},
        Typo{"zones",
             "tensor_zones zones=/nonexistent.json",
             kTensor,
             {"WEIR-4001", "nonexistent.json"}},
        Typo{"engine",
             "tensor_filter framework=onnxruntim model=x.onnx",
             kTensor,
             {"WEIR-3001", "onnxruntim", "onnxruntime"}},
        Typo{"model",
             "tensor_filter framework=fake model=/nonexistent.bin",
             kTensor,
             {"WEIR-3003", "nonexistent.bin"}},
        Typo{"merge_dimension",
             "tensor_merge option=x",
             kTensor,
             {"option is not a dimension", "x"}},
        Typo{"mux_base",
             "tensor_mux sync-mode=basepad sync-option=0:y",
             kTensor,
             {"WEIR-1001: sync-option cannot be read", "0:y"}},
        Typo{"if_value", "tensor_if supplied-value=z", kTensor, {"WEIR-1", "z"}},
        Typo{"split_segment", "tensor_split tensorseg=a:b", kTensor, {"WEIR-1", "a:b"}},
        Typo{"demux_pick", "tensor_demux tensorpick=w", kTensor, {"WEIR-1", "w"}},
        Typo{"no_loop_caps", "tensor_reposrc slot-index=903", "", {"property caps is not set"}},
        Typo{"no_model", "tensor_filter framework=fake", kTensor, {"WEIR-"}}),
    [](const auto& info) { return std::string(info.param.name); });

}  // namespace bad_properties_test
