# Run as a script: turns files into one C header of NUL-terminated char arrays, named after the files (light.frag -> light_frag).
# A byte array, because C11 promises string literals of no more than 4,095 characters.
#   cmake -DOUTPUT=shaders.h -DINPUTS=a.glsl;b.frag -P EmbedShaders.cmake
set(text "/* Made from demo/shaders at build time. */\n")
foreach(input IN LISTS INPUTS)
  get_filename_component(name ${input} NAME)
  string(MAKE_C_IDENTIFIER ${name} name)
  file(READ ${input} bytes HEX)
  string(REGEX REPLACE "(................................................................)" "\\1\n" bytes "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(APPEND text "static const char shader_${name}[] = {\n${bytes}0x00};\n")
endforeach()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "${text}" @ONLY)
