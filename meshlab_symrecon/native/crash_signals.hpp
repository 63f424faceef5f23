// The signals by which native code that goes wrong ends its process, and the sentence that tells of it.
#pragma once

#include <string>

#ifndef _WIN32

namespace symrecon {

constexpr int no_signal = 0;  // for native code that calls exit()

// What is true of the files that were to be written, when a process crashes.
enum class Files { none_written, taking_their_places, some_written };

// Answer crashes of this process from now on: `pipe` gets the signal's number, and whoever reads there has two seconds
// to tidy up and to end the process; then the sentence is written to `said_to` and `log`, and the process ends.
void catch_crashes(int pipe, int said_to);
void let_crashes_be();

void crash_log(int log);          // -1 for none
void crash_files(Files files);
void crash_step(const std::string& step);  // what is being done; its end is left out when it is long

// Return the sentence, once: whoever has got it writes it. Empty when it is another's.
std::string take_crash_sentence(int number);

}  // namespace symrecon

#endif
