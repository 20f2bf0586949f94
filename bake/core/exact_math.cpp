// Replaces the functions of <cmath> whose results depend on the processor. glibc has several versions of sin, pow, log2 and others, and
// takes one with fused multiply-adds where the processor has them. About one result in a thousand then differs in its last bit, and so does
// the baked file. SLEEF's "cinz" functions are plain C without fused operations. A program that links the baker has these in place of the C
// library's for all callers: the baker, the module that writes the format, and Draco. The processor keeps + - * / and sqrt, which IEEE 754
// defines to the bit.
//
// Float functions round the double ones. Functions that are exact anyway (sqrt, floor, lround, fmod, ldexp) stay the C library's.

#include <sleef.h>

#include <cmath>

// The function of doubles and that of floats, of one argument or two.
#define COPPICE_EXACT_1(name, sleef)             \
  double name(double x) noexcept {               \
    return sleef(x);                             \
  }                                              \
  float name##f(float x) noexcept {              \
    return static_cast<float>(sleef(double{x})); \
  }
#define COPPICE_EXACT_2(name, sleef)                        \
  double name(double x, double y) noexcept {                \
    return sleef(x, y);                                     \
  }                                                         \
  float name##f(float x, float y) noexcept {                \
    return static_cast<float>(sleef(double{x}, double{y})); \
  }

extern "C" {

COPPICE_EXACT_1(sin, Sleef_cinz_sind1_u10purec)
COPPICE_EXACT_1(cos, Sleef_cinz_cosd1_u10purec)
COPPICE_EXACT_1(tan, Sleef_cinz_tand1_u10purec)
COPPICE_EXACT_1(asin, Sleef_cinz_asind1_u10purec)
COPPICE_EXACT_1(acos, Sleef_cinz_acosd1_u10purec)
COPPICE_EXACT_1(atan, Sleef_cinz_atand1_u10purec)
COPPICE_EXACT_2(atan2, Sleef_cinz_atan2d1_u10purec)
COPPICE_EXACT_1(exp, Sleef_cinz_expd1_u10purec)
COPPICE_EXACT_1(exp2, Sleef_cinz_exp2d1_u10purec)
COPPICE_EXACT_1(log, Sleef_cinz_logd1_u10purec)
COPPICE_EXACT_1(log2, Sleef_cinz_log2d1_u10purec)
COPPICE_EXACT_1(log10, Sleef_cinz_log10d1_u10purec)
COPPICE_EXACT_1(cbrt, Sleef_cinz_cbrtd1_u10purec)
COPPICE_EXACT_2(hypot, Sleef_cinz_hypotd1_u05purec)

double pow(double x, double y) noexcept {
  return Sleef_cinz_powd1_u10purec(x, y);
}
float powf(float x, float y) noexcept {
  // It takes a third of pow's time and is exact enough for a float. Bases that are not positive have rules of their own, which pow knows.
  if (x > 0.0f && x < 1e30f && y > -8.0f && y < 8.0f) return static_cast<float>(exp(double{y} * Sleef_cinz_logd1_u35purec(double{x})));
  return static_cast<float>(pow(double{x}, double{y}));
}

// g++ makes one call of a sine and a cosine of the same angle.
void sincos(double x, double* sine, double* cosine) noexcept {
  *sine = sin(x);
  *cosine = cos(x);
}
void sincosf(float x, float* sine, float* cosine) noexcept {
  *sine = sinf(x);
  *cosine = cosf(x);
}

}  // extern "C"
