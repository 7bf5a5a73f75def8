/* Text that grows, with what JSON needs. When memory runs short the text is dropped and further calls do nothing. */
#ifndef TEXT_H
#define TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct text_buffer {
  char* bytes;
  size_t length, capacity;
  bool failed;
} text_buffer;

void text_add(text_buffer* text, const char* string);
void text_add_bytes(text_buffer* text, const char* bytes, size_t count);
#ifdef __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
void text_format(text_buffer* text, const char* format, ...); /* at most 255 bytes a call */

/* Two spaces a level. */
void text_indent(text_buffer* text, uint32_t levels);

/* A JSON string with its quotes. `string` is UTF-8. */
void text_string(text_buffer* text, const char* string);

/* The shortest decimal that reads back as the same number; a number that is not finite becomes 0, which JSON can hold. */
void text_number(text_buffer* text, double value);
void text_float(text_buffer* text, float value);

/* Hands over the bytes, NUL-terminated, to be freed with free; NULL when memory ran short. The text is empty afterwards. */
char* text_take(text_buffer* text, size_t* size);
void text_free(text_buffer* text);

#endif
