/* The stable error codes of Weir. docs/errors/WEIR-<number>.md explains each. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_CODES_H
#define WEIR_CODES_H

/* X(NAME, NUMBER, TITLE), one line per code. Never reuse a number. */
#define WEIR_ERROR_CODES(X)                                                               \
  X(OPTION_SYNTAX, 1001, "An option or property text cannot be read")                     \
  X(DIMENSION_SYNTAX, 1002, "A dimension text cannot be read")                            \
  X(TYPE_SYNTAX, 1003, "An element type is unknown")                                      \
  X(OPTION_VALUE, 1004, "An option or property has a value that cannot be used")          \
  X(MODE_UNKNOWN, 1005, "A mode is unknown")                                              \
  X(SPEC_MISMATCH, 2001, "The stream does not fit what the element or model needs")       \
  X(FORMAT_UNSUPPORTED, 2002, "The stream has a format that the element does not accept") \
  X(NOT_NEGOTIATED, 2003, "Data arrived before the format was negotiated")                \
  X(FRAME_SIZE, 2004, "A frame's size does not match its format")                         \
  X(HEADER_INVALID, 2005, "A tensor header is damaged or inconsistent")                   \
  X(LIMIT_EXCEEDED, 2006, "A size or count is beyond the limits of the stream type")      \
  X(MAPPING_FAILED, 2007, "Memory cannot be mapped")                                      \
  X(TIME_INVALID, 2008, "A timestamp is missing or goes backwards")                       \
  X(ENGINE_UNKNOWN, 3001, "No engine of this name is known")                              \
  X(ENGINE_NOT_INSTALLED, 3002, "The engine is known but not installed")                  \
  X(MODEL_NOT_FOUND, 3003, "The model file does not exist")                               \
  X(MODEL_INVALID, 3004, "The file is truncated, damaged or not a model")                 \
  X(MODEL_UNSUPPORTED, 3005, "The model needs something that the engine lacks")           \
  X(INVOKE_FAILED, 3006, "The engine failed while it ran the model")                      \
  X(MODULE_REFUSED, 3007, "A module file cannot be used")                                 \
  X(CARD_MISSING, 3008, "No model card describes how to prepare the input")               \
  X(CARD_INVALID, 3009, "A model card cannot be used")                                    \
  X(DECODER_UNKNOWN, 3010, "No decoder of this name is known")                            \
  X(CONVERTER_UNKNOWN, 3011, "No converter of this name is known")                        \
  X(MODEL_DIFFERS, 3012, "A model cannot replace another")                                \
  X(BATCH_UNSUPPORTED, 3013, "Frames cannot be batched for this model")                   \
  X(WORKER_ENDED, 3014, "The worker process of a model ended")                            \
  X(WORKER_TIMEOUT, 3015, "A model timed out")                                            \
  X(WORKER_NOT_STARTED, 3016, "The worker process of a model could not be started")       \
  X(FALLS_BEHIND, 3017, "A model is slower than its live source")                         \
  X(FILE_NOT_FOUND, 4001, "A file does not exist or cannot be read")                      \
  X(LABELS_INVALID, 4002, "A label file is empty or does not fit the model")              \
  X(SAMPLES_INVALID, 4003, "A file of samples, or its description, cannot be used")       \
  X(FILE_NOT_WRITTEN, 4010, "A file cannot be written")                                   \
  X(DOWNLOAD_FAILED, 4011, "A file cannot be fetched, or is not the expected one")        \
  X(GRAPH_STALLS, 5001, "Elements of a pipeline wait for each other (deadlock)")          \
  X(CALLBACK_UNKNOWN, 5002, "No callback of this name is registered")                     \
  X(CALLBACK_FAILED, 5003, "A callback of the application failed")                        \
  X(SERVER_UNREACHABLE, 6001, "A server cannot be reached")                               \
  X(SERVER_REFUSED, 6002, "A server refused a request")                                   \
  X(CONNECTION_INSECURE, 6003, "A connection to another machine is not encrypted")        \
  X(PEER_MESSAGE_INVALID, 6004, "A peer sent a message that cannot be used")              \
  X(BROKER_UNREACHABLE, 6005, "An MQTT broker cannot be reached")                         \
  X(BROKER_REFUSED, 6006, "An MQTT broker and its client do not accept each other")       \
  X(CANCELLED, 8001, "The work was cancelled")                                            \
  X(OUT_OF_MEMORY, 9001, "Out of memory")                                                 \
  X(INTERNAL, 9002, "A fault inside Weir")

/* ABI functions return 0 on success and a negated code on failure: -WEIR_MODEL_INVALID. */
enum weir_code {
  WEIR_OK = 0,
#define WEIR_CODE_ENUM(name, number, title) WEIR_##name = number,
  WEIR_ERROR_CODES(WEIR_CODE_ENUM)
#undef WEIR_CODE_ENUM
};

#endif /* WEIR_CODES_H */
