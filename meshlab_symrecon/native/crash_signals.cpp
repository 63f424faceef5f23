#include "crash_signals.hpp"

#ifndef _WIN32

#include <signal.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstring>
#include <iterator>

// What runs in a handler calls only what POSIX allows there: the heap may be locked, or broken.
namespace symrecon {
namespace {

constexpr int caught[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
constexpr const char* names[] = {"SIGSEGV", "SIGBUS", "SIGFPE", "SIGILL", "SIGABRT"};
constexpr std::size_t kinds = std::size(caught);
constexpr std::size_t longest_step = 1024;
constexpr std::size_t longest_sentence = longest_step + 512;
constexpr int patience = 2;     // seconds
constexpr int exit_code = 1;
constexpr const char* clearing = "\r\x1b[2K\x1b[?25h";  // of a terminal's line, with the bar; and the cursor is shown

alignas(16) char spare_stack[1 << 16];  // for a handler that runs because the stack is full
struct sigaction before[kinds];
std::atomic<bool> catching{false}, crashed{false}, taken{false};
std::atomic<pid_t> owner{0};
std::atomic<int> told{-1}, shown_on{-1}, noted_in{-1};
std::atomic<bool> on_terminal{false};
std::atomic<Files> files{Files::none_written};

// Two of them: one is whole while the other one is written.
char steps[2][longest_step + 1];
std::atomic<int> step{0};

class Sentence {
 public:
  explicit Sentence(int number) {
    append("error: ");
    const char* doing = steps[step.load()];
    if (*doing != '\0') append(doing), append(": ");
    append(number == no_signal ? "native code ended the process" : "MeshLab's native code ended the process by ");
    for (std::size_t kind = 0; kind < kinds; ++kind)
      if (caught[kind] == number) append(names[kind]);
    switch (files.load()) {
      case Files::none_written: append("; nothing was written"); break;
      case Files::taking_their_places: append("; each file that was being replaced is whole, the old or the new one"); break;
      case Files::some_written: append("; what was written before is whole"); break;
    }
    append("; leave that step out, or run it in the MeshLab program");
  }

  const char* text() const { return text_; }

  void write_to(int descriptor, const char* end) const {
    if (descriptor < 0) return;
    ssize_t done = write(descriptor, text_, length_);
    done = write(descriptor, end, std::strlen(end));
    (void)done;
  }

 private:
  void append(const char* more) {
    while (*more != '\0' && length_ < longest_sentence) text_[length_++] = *more++;
    text_[length_] = '\0';
  }

  char text_[longest_sentence + 1];
  std::size_t length_ = 0;
};

// Let those who caught crashes before us do it too, as Python's faulthandler, which shows where each thread is. Some
// send the signal again, to end the process: it waits, since it is blocked in here.
void call_earlier(int number, siginfo_t* information, void* context) {
  for (std::size_t kind = 0; kind < kinds; ++kind) {
    const struct sigaction& earlier = before[kind];
    if (caught[kind] != number) continue;
    if (earlier.sa_flags & SA_SIGINFO) {
      if (earlier.sa_sigaction != nullptr) earlier.sa_sigaction(number, information, context);
    } else if (earlier.sa_handler != SIG_DFL && earlier.sa_handler != SIG_IGN) {
      earlier.sa_handler(number);
    }
  }
}

void wait_for_the_end() {
  timespec began{}, now{};
  clock_gettime(CLOCK_MONOTONIC, &began);
  do {
    const timespec nap{0, 10'000'000};
    nanosleep(&nap, nullptr);
    clock_gettime(CLOCK_MONOTONIC, &now);
  } while (now.tv_sec - began.tv_sec < patience + (now.tv_nsec < began.tv_nsec ? 1 : 0));
}

void on_crash(int number, siginfo_t* information, void* context) {
  if (!catching || owner != getpid()) {  // a copy of the process, which has nobody to tidy up
    signal(number, SIG_DFL);
    raise(number);  // as soon as this returns
    return;
  }
  while (crashed.exchange(true)) pause();  // another thread has crashed already
  if (shown_on >= 0) dup2(shown_on, STDERR_FILENO);  // it may be diverted
  call_earlier(number, information, context);
  const unsigned char byte = static_cast<unsigned char>(number);
  if (write(told, &byte, 1) == 1) wait_for_the_end();
  if (!taken.exchange(true)) {
    const Sentence sentence(number);
    sentence.write_to(noted_in, "\n");
    if (on_terminal) {
      const ssize_t cleared = write(shown_on, clearing, std::strlen(clearing));
      (void)cleared;
    }
    sentence.write_to(shown_on, "\n");
  }
  _exit(exit_code);
}

}  // namespace

void catch_crashes(int pipe, int said_to) {
  told = pipe;
  shown_on = said_to;
  on_terminal = said_to >= 0 && isatty(said_to) != 0;
  if (catching) return;
  owner = getpid();
  crashed = taken = false;
  files = Files::none_written;
  crash_step("");
  stack_t stack{};
  if (sigaltstack(nullptr, &stack) == 0 && (stack.ss_flags & SS_DISABLE) != 0) {
    stack.ss_sp = spare_stack;
    stack.ss_size = sizeof spare_stack;
    stack.ss_flags = 0;
    sigaltstack(&stack, nullptr);
  }
  struct sigaction ours{};
  ours.sa_sigaction = on_crash;
  ours.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigfillset(&ours.sa_mask);
  for (std::size_t kind = 0; kind < kinds; ++kind) sigaction(caught[kind], &ours, &before[kind]);
  catching = true;
}

void let_crashes_be() {
  if (!catching) return;
  for (std::size_t kind = 0; kind < kinds; ++kind) {
    struct sigaction now{};
    sigaction(caught[kind], nullptr, &now);
    const bool ours = (now.sa_flags & SA_SIGINFO) != 0 && now.sa_sigaction == on_crash;
    if (ours) sigaction(caught[kind], &before[kind], nullptr);
  }
  catching = false;
  noted_in = -1;
}

void crash_log(int log) { noted_in = log; }

void crash_files(Files now) { files = now; }

void crash_step(const std::string& doing) {
  const int other = 1 - step.load();
  const std::size_t length = doing.copy(steps[other], longest_step);
  steps[other][length] = '\0';
  step = other;
}

std::string take_crash_sentence(int number) { return taken.exchange(true) ? "" : Sentence(number).text(); }

}  // namespace symrecon

#endif
