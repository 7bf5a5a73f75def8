/* Text that grows, with what JSON needs. When memory runs short the text is dropped and further calls do nothing. */
#ifndef BUFFER_H
#define BUFFER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct text_buffer {
  char* bytes;
  size_t length, capacity;
  bool failed;
} text_buffer;

void buffer_add(text_buffer* text, const char* string);
void buffer_add_bytes(text_buffer* text, const char* bytes, size_t count);
#ifdef __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
void buffer_format(text_buffer* text, const char* format, ...); /* at most 255 bytes a call */

/* Two spaces a level. */
void buffer_indent(text_buffer* text, uint32_t levels);

/* A JSON string with its quotes. `string` is UTF-8. */
void buffer_string(text_buffer* text, const char* string);

/* The shortest decimal that reads back as the same number; a number that is not finite becomes 0, which JSON can hold. */
void buffer_number(text_buffer* text, double value);
void buffer_float(text_buffer* text, float value);

/* Hands over the bytes, NUL-terminated, to be freed with free; NULL when memory ran short. The text is empty afterwards. */
char* buffer_take(text_buffer* text, size_t* size);
void buffer_free(text_buffer* text);

#endif
