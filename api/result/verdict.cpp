#include "api/result/verdict.h"

namespace meshgauge::api {

std::string_view to_string(Verdict verdict) { return name_of(kVerdicts, verdict); }

int severity(Verdict verdict) { return verdict == Verdict::fail ? 2 : verdict == Verdict::undecided ? 1 : 0; }

Verdict worst(Verdict a, Verdict b) { return severity(a) < severity(b) ? b : a; }

Verdict verdict_within(double lower, double upper, const LimitEnds& ends) {
  if (upper <= ends.pass) return Verdict::pass;
  return lower > ends.fail ? Verdict::fail : Verdict::undecided;
}

}  // namespace meshgauge::api
