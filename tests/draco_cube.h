/* Draco bytes with texture coordinates, which none of the programs writes. The C side of draco_cube.cpp. */
#ifndef DRACO_CUBE_H
#define DRACO_CUBE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A mesh with the attributes POSITION, floats of unique id 0, and TEX_COORD, of unique id 1. one: 0 = TEX_COORD are floats, too;
 * 255 or 65535 = integers of 8 or 16 bits that stand for 1 at this value. positions: 3 * vertex_count. uvs: 2 * vertex_count.
 * indices: 3 * triangle_count. Returns the size, or 0 where Draco refuses the mesh or `capacity` is too small. */
size_t draco_cube_encode(const float* positions, const float* uvs, uint32_t vertex_count, const uint16_t* indices,
                         uint32_t triangle_count, uint32_t one, char* bytes, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
