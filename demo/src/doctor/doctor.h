#pragma once

namespace forest {

/// Tries what Coppice does on this machine, a trial at a time (trial.h), then this program itself; prints how each went, and a text for a
/// bug report. version  of this program
/// returns  the exit code: 0 when all went well, else 1
/// errors  Failure: this program cannot be started again, no temporary file
int run_doctor(double limit_s, const char* version);

}  // namespace forest
