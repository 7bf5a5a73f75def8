#define KERNELS_TABLE weather_kernels_avx2
#define KERNELS_NAME "avx2"
#include "weather_kernels_body.h"
