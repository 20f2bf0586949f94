// Replaces the functions of <cmath> whose results depend on the processor. glibc has several versions of sin, pow, log2 and others, and
// takes one with fused multiply-adds where the processor has them. About one result in a thousand then differs in its last bit, and so does
// the baked file. SLEEF's "cinz" functions are plain C without fused operations. A program that links the baker has these in place of the C
// library's for all callers: the baker, the module that writes the format, and Draco. The processor keeps + - * / and sqrt, which IEEE 754
// defines to the bit.
//
// Float functions round the double ones. Functions that are exact anyway (sqrt, floor, lround, fmod, ldexp) stay the C library's.

#include <sleef.h>

#include <cmath>

extern "C" {

double sin(double x) noexcept {
  return Sleef_cinz_sind1_u10purec(x);
}
double cos(double x) noexcept {
  return Sleef_cinz_cosd1_u10purec(x);
}
double tan(double x) noexcept {
  return Sleef_cinz_tand1_u10purec(x);
}
double asin(double x) noexcept {
  return Sleef_cinz_asind1_u10purec(x);
}
double acos(double x) noexcept {
  return Sleef_cinz_acosd1_u10purec(x);
}
double atan(double x) noexcept {
  return Sleef_cinz_atand1_u10purec(x);
}
double atan2(double y, double x) noexcept {
  return Sleef_cinz_atan2d1_u10purec(y, x);
}
double exp(double x) noexcept {
  return Sleef_cinz_expd1_u10purec(x);
}
double exp2(double x) noexcept {
  return Sleef_cinz_exp2d1_u10purec(x);
}
double log(double x) noexcept {
  return Sleef_cinz_logd1_u10purec(x);
}
double log2(double x) noexcept {
  return Sleef_cinz_log2d1_u10purec(x);
}
double log10(double x) noexcept {
  return Sleef_cinz_log10d1_u10purec(x);
}
double pow(double x, double y) noexcept {
  return Sleef_cinz_powd1_u10purec(x, y);
}
double cbrt(double x) noexcept {
  return Sleef_cinz_cbrtd1_u10purec(x);
}
double hypot(double x, double y) noexcept {
  return Sleef_cinz_hypotd1_u05purec(x, y);
}
// g++ makes one call of a sine and a cosine of the same angle.
void sincos(double x, double* sine, double* cosine) noexcept {
  *sine = sin(x);
  *cosine = cos(x);
}

float sinf(float x) noexcept {
  return static_cast<float>(sin(double{x}));
}
float cosf(float x) noexcept {
  return static_cast<float>(cos(double{x}));
}
float tanf(float x) noexcept {
  return static_cast<float>(tan(double{x}));
}
float asinf(float x) noexcept {
  return static_cast<float>(asin(double{x}));
}
float acosf(float x) noexcept {
  return static_cast<float>(acos(double{x}));
}
float atanf(float x) noexcept {
  return static_cast<float>(atan(double{x}));
}
float atan2f(float y, float x) noexcept {
  return static_cast<float>(atan2(double{y}, double{x}));
}
float expf(float x) noexcept {
  return static_cast<float>(exp(double{x}));
}
float exp2f(float x) noexcept {
  return static_cast<float>(exp2(double{x}));
}
float logf(float x) noexcept {
  return static_cast<float>(log(double{x}));
}
float log2f(float x) noexcept {
  return static_cast<float>(log2(double{x}));
}
float log10f(float x) noexcept {
  return static_cast<float>(log10(double{x}));
}
float powf(float x, float y) noexcept {
  // It takes a third of pow's time and is exact enough for a float. Bases that are not positive have rules of their own, which pow knows.
  if (x > 0.0f && x < 1e30f && y > -8.0f && y < 8.0f) return static_cast<float>(exp(double{y} * Sleef_cinz_logd1_u35purec(double{x})));
  return static_cast<float>(pow(double{x}, double{y}));
}
float cbrtf(float x) noexcept {
  return static_cast<float>(cbrt(double{x}));
}
float hypotf(float x, float y) noexcept {
  return static_cast<float>(hypot(double{x}, double{y}));
}
void sincosf(float x, float* sine, float* cosine) noexcept {
  *sine = sinf(x);
  *cosine = cosf(x);
}

}  // extern "C"
