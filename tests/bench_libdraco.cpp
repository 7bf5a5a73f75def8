#include "bench_libdraco.h"

#include <draco/compression/decode.h>

bool bench_libdraco_decode(const uint8_t* blob, size_t size) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(blob), size);
  draco::Mesh mesh;
  draco::Decoder decoder;
  return decoder.DecodeBufferToGeometry(&buffer, &mesh).ok();
}
