// What the target random_pipeline makes its pipelines of: elements, caps with the size of their
// frames, values of properties.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string_view>

namespace weir::fuzz {

// Elements as gst_parse_launch() reads them, with properties that suit some of kFormats.
inline constexpr const char* kElements[] = {
    "join",
    "tensor_aggregator frames-out=2",
    "tensor_aggregator frames-out=3 frames-flush=1 frames-dim=1",
    "tensor_aggregator frames-in=2 frames-out=1 frames-dim=3 concat=false",
    "tensor_converter",
    "tensor_converter frames-per-tensor=3",
    "tensor_converter input-dim=4:2 input-type=uint8",
    "tensor_crop",
    "tensor_crop lateness=20",
    "tensor_debug",
    "tensor_decoder mode=octet_stream",
    "tensor_decoder mode=direct_video",
    "tensor_decoder mode=json",
    "tensor_decoder mode=webvtt",
    "tensor_decoder mode=coco",
    "tensor_decoder mode=mot",
    "tensor_decoder mode=detection custom=head:yolov8,input:32:32",
    "tensor_decoder mode=bounding_boxes option1=yolov5 option4=16:16 option5=32:32",
    "tensor_decoder mode=image_segment option1=tflite-deeplab option2=2",
    "tensor_decoder mode=pose_estimation option1=16:16 option2=2:2",
    "tensor_demux",
    "tensor_demux tensorpick=1,0:1",
    "tensor_filter framework=custom-easy model=adding",
    "tensor_filter framework=custom-easy model=same",
    "tensor_filter framework=custom-easy model=nothing",
    "tensor_filter framework=custom-easy model=failing",
    "tensor_filter framework=custom-easy model=same workers=2",
    "tensor_filter framework=custom-easy model=same workers=2 when-busy=drop-old",
    "tensor_filter framework=custom-easy model=same batch-size=2",
    "tensor_filter framework=custom-easy model=adding input-combination=0 "
    "output-combination=i0,o0",
    "tensor_from_roi",
    "tensor_if compared-value=A_VALUE compared-value-option=0:0:0:0,0 operator=GT "
    "supplied-value=100 then=PASSTHROUGH else=SKIP",
    "tensor_if compared-value=TENSOR_AVERAGE_VALUE compared-value-option=0 operator=LT "
    "supplied-value=50 then=TENSORPICK then-option=0 else=PASSTHROUGH",
    "tensor_merge mode=linear option=0 sync-mode=slowest",
    "tensor_merge mode=linear option=2 sync-mode=refresh",
    "tensor_mux",
    "tensor_mux sync-mode=nosync",
    "tensor_mux sync-mode=refresh",
    "tensor_mux sync-mode=basepad sync-option=0:20000000",
    "tensor_mux sync-mode=slowest max-wait=1000000",
    "tensor_overlay",
    "tensor_overlay sync=same-time trail-length=3 color-by=track",
    "tensor_preprocess width=4 height=4",
    "tensor_preprocess sizes=8x8,4x2 method=area",
    "tensor_preprocess width=6 height=4 fit=letterbox layout=NCHW scale=0.5",
    "tensor_preprocess width=2 height=2 regions=pad",
    "tensor_preprocess width=2 height=2 regions=meta",
    "tensor_rate framerate=15/1",
    "tensor_rate framerate=45/1 throttle=false",
    "tensor_sink",
    "tensor_sparse_dec",
    "tensor_sparse_enc",
    "tensor_split tensorseg=1:8:8,2:8:8",
    "tensor_split split-dim=0 split-parts=2",
    "tensor_to_roi",
    "tensor_tracker",
    "tensor_tracker min-hits=0 mode=iou",
    "tensor_transform mode=typecast option=float32",
    "tensor_transform mode=typecast option=uint8",
    "tensor_transform mode=arithmetic option=add:1",
    "tensor_transform mode=arithmetic option=typecast:float32,add:-1,div:0",
    "tensor_transform mode=transpose option=1:0:2:3",
    "tensor_transform mode=dimchg option=0:2",
    "tensor_transform mode=stand option=default:float32,per-channel:true",
    "tensor_transform mode=clamp option=1:9",
    "tensor_transform mode=padding option=left:1,right:1,top:1,bottom:1",
    "tensor_zones",
    "queue",
    "queue leaky=downstream max-size-buffers=1",
    "tee"};

// Caps of a source, and the bytes of each memory of one of its frames; 0: any, or none.
enum class Header { None, Flexible, Sparse };
struct SourceFormat {
  const char* caps;
  size_t bytes[3];
  Header header = Header::None;
};
#define TENSORS(count, dimensions, types)                                              \
  "other/tensors,format=static,num_tensors=" count ",dimensions=(string)\"" dimensions \
  "\",types=(string)\"" types "\",framerate=30/1"
inline constexpr SourceFormat kFormats[] = {
    {TENSORS("1", "4:1:1:1", "uint8"), {4}},
    {TENSORS("1", "3:8:8:1", "uint8"), {192}},
    {TENSORS("1", "2:3", "float32"), {24}},
    {TENSORS("2", "2:2,3", "int16,float64"), {8, 24}},
    {TENSORS("3", "4,2,1:2", "uint8,int8,uint32"), {4, 2, 8}},
    {TENSORS("1", "4:2", "float16"), {16}},
    {TENSORS("1", "7:21:1", "float32"), {588}},
    {TENSORS("1", "6:2", "float32"), {48}},
    {TENSORS("1", "3:4:4", "float32"), {192}},
    {TENSORS("1", "14:2:2", "float32"), {224}},
    {TENSORS("1", "5:2", "float32") ",weir-columns=(string)\"x1,y1,x2,y2,track\"", {40}},
    {TENSORS("1", "4:2", "uint32"), {32}},
    {"other/tensors,format=flexible,framerate=30/1", {0}, Header::Flexible},
    {"other/tensors,format=flexible,framerate=30/1,"
     "weir-columns=(string)\"x1,y1,x2,y2,score,class\"",
     {0},
     Header::Flexible},
    {"other/tensors,format=sparse,framerate=0/1", {0}, Header::Sparse},
    {"other/tensor,dimension=4,type=int8,framerate=30/1", {4}},
    {"other/tensors", {0}},
    {"video/x-raw,format=RGB,width=8,height=6,framerate=30/1", {144}},
    {"video/x-raw,format=GRAY8,width=5,height=3,framerate=0/1", {24}},
    {"video/x-raw,format=I420,width=7,height=5,framerate=30/1", {72}},
    {"video/x-raw,format=NV12,width=8,height=4,framerate=30/1", {48}},
    {"video/x-raw,format=RGBA,width=16,height=16,framerate=30/1", {1024}},
    {"video/x-raw,format=BGRx,width=4,height=4,framerate=30/1", {64}},
    {"audio/x-raw,format=S16LE,layout=interleaved,channels=2,rate=8000", {32}},
    {"audio/x-raw,format=F32LE,layout=interleaved,channels=1,rate=8000", {32}},
    {"text/x-raw,format=utf8", {0}},
    {"application/octet-stream,framerate=30/1", {8}},
};
#undef TENSORS

// Properties that would make a pipeline wait for a clock or a person, and those of every element.
// Other ones are GStreamer's, whose elements say wrong latencies (min-threshold-time) or do not
// start (has-chain) with any value.
inline constexpr std::string_view kLeftAlone[] = {
    "sync",      "ts-offset",     "render-delay",    "name",
    "parent",    "throttle-time", "async",           "max-bitrate",
    "blocksize", "threads",       "max-buffer-size", "max-lateness",
    "has-chain", "pull-mode",     "alloc-pad",       "min-threshold-time"};

// Values of properties that are numbers; those outside of the range are refused by GObject.
inline constexpr const char* kNumbers[] = {"0",  "1",   "2",  "3",   "4",      "7",
                                           "16", "100", "-1", "0.5", "1000000"};
// Values of properties that are texts.
inline constexpr const char* kTexts[] = {"typecast",
                                         "arithmetic",
                                         "transpose",
                                         "dimchg",
                                         "stand",
                                         "clamp",
                                         "padding",
                                         "linear",
                                         "float32",
                                         "uint8",
                                         "int64",
                                         "float16",
                                         "add:1,mul:2",
                                         "typecast:float32,div:0",
                                         "1:0:2:3",
                                         "0:2",
                                         "default",
                                         "dc-average:float32,per-channel:true",
                                         "-1:1",
                                         "left:1,right:1",
                                         "direct_video",
                                         "octet_stream",
                                         "image_labeling",
                                         "bounding_boxes",
                                         "image_segment",
                                         "pose_estimation",
                                         "detection",
                                         "classification",
                                         "segmentation",
                                         "pose",
                                         "depth",
                                         "text",
                                         "tensor_region",
                                         "json",
                                         "webvtt",
                                         "coco",
                                         "mot",
                                         "yolov5",
                                         "mobilenet-ssd",
                                         "head:yolov8,input:32:32",
                                         "tflite-deeplab",
                                         "0",
                                         "1",
                                         "2",
                                         "0,1",
                                         "1,1",
                                         "0:1,2",
                                         "2:2",
                                         "4:1:1:1",
                                         "3:8:8:1",
                                         "8:8",
                                         "i0,o0",
                                         "8x8,4x4",
                                         "nosync",
                                         "slowest",
                                         "basepad",
                                         "refresh",
                                         "0:10000000",
                                         "1/2",
                                         "30/1",
                                         "0:0:0:0,0",
                                         "custom-easy",
                                         "cpp",
                                         "auto",
                                         "same",
                                         "nothing",
                                         "failing",
                                         "adding",
                                         "a",
                                         "/nonexistent",
                                         ""};

}  // namespace weir::fuzz
