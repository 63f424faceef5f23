// The end of the process within a second of Ctrl-C, also while other native code keeps the interpreter waiting.
//
// Python's own handler writes the number of each signal into a pipe (signal.set_wakeup_fd), even while no Python code
// can run. A thread reads it there. When the work has not come to an end by itself after a grace, the thread removes
// what the process was writing, says so, and ends the process. It does so at once when native code has crashed.
#include <nanobind/stl/string.h>

#include "bindings.hpp"
#include "crash_signals.hpp"

#ifndef _WIN32

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <mutex>
#include <set>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#endif

namespace symrecon {
namespace {

#ifndef _WIN32

using namespace std::chrono_literals;
namespace files = std::filesystem;

constexpr auto longest_replacing = 5s;  // renames take microseconds, but on a network's disk
constexpr auto longest_dying = 200ms;   // of a child that was killed
constexpr int sweeps = 20;              // the work goes on, and may write into a folder while it is removed
constexpr int exit_code_of_signals = 128;
constexpr auto longest_replacing_of_crashed = 1s;  // within the patience of the crashed thread
constexpr int exit_code_of_crashes = 1;

// Write what fits, without waiting for a reader that has stopped reading.
void write_text(int descriptor, const std::string& text) {
  pollfd ready{descriptor, POLLOUT, 0};
  if (descriptor < 0 || poll(&ready, 1, 100) <= 0) return;
  const ssize_t written = write(descriptor, text.data(), text.size());
  (void)written;
}

void watch_over_exit();

class Watch {
 public:
  // Start to watch; return the end of the pipe that signals are to be written into.
  int begin(double grace, std::string sentence) {
    const std::lock_guard lock(mutex_);
    if (pipe_[1] < 0) open();
    if (said_to_ >= 0) close(said_to_);
    said_to_ = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);  // the stream may be diverted for a while
    grace_ = std::chrono::duration<double>(grace);
    sentence_ = std::move(sentence);
    watching_ = true;
    reached_ = false;
    catch_crashes(pipe_[1], said_to_);
    return pipe_[1];
  }

  void end() {
    const std::lock_guard lock(mutex_);
    watching_ = false;
    folders_.clear();
    children_.clear();
    log_ = -1;
    let_crashes_be();
    changed_.notify_all();
  }

  // The work has stopped and has been tidied up: no need to end the process.
  void acknowledge() {
    const std::lock_guard lock(mutex_);
    reached_ = true;
    changed_.notify_all();
  }

  void guard_folder(const std::string& folder, const std::string& prefix) {
    const std::lock_guard lock(mutex_);
    if (watching_) folders_.emplace(folder, prefix);
  }

  void guard_process(int process, bool guarded) {
    const std::lock_guard lock(mutex_);
    if (guarded && watching_) children_.insert(process);
    if (!guarded) children_.erase(process);
  }

  void guard_log(int descriptor) {
    const std::lock_guard lock(mutex_);
    log_ = descriptor;
    crash_log(descriptor);
  }

  void replacing(bool begins) {
    const std::lock_guard lock(mutex_);
    replacing_ += begins ? 1 : -1;
    crash_files(replacing_ ? Files::taking_their_places : Files::some_written);
    changed_.notify_all();
  }

  // Native code has called exit() amid the work, as OpenBLAS does when there is no memory left.
  void end_at_exit() {
    if (getpid() != process_ || !watching_) return;
    answer_crash(no_signal);
  }

  void sweep() {
    const std::lock_guard lock(mutex_);
    remove_guarded();
  }

 private:
  void open() {
    if (pipe(pipe_) != 0) throw std::runtime_error("no pipe can be opened");
    for (const int end : pipe_) fcntl(end, F_SETFD, FD_CLOEXEC);
    fcntl(pipe_[1], F_SETFL, O_NONBLOCK);  // as signal.set_wakeup_fd wants it
    std::thread([this] { wait_for_signals(); }).detach();
    std::atexit([] { watch_over_exit(); });
  }

  void wait_for_signals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);  // the handlers belong to Python's threads
    for (;;) {
      unsigned char number = 0;
      const ssize_t got = read(pipe_[0], &number, 1);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return;
      if (number == SIGINT || number == SIGTERM || number == SIGHUP)
        answer(number);
      else
        answer_crash(number);
    }
  }

  void answer_crash(int number) {
    std::unique_lock lock(mutex_);
    if (!watching_) return;
    changed_.wait_for(lock, longest_replacing_of_crashed, [this] { return replacing_ == 0; });
    tidy_up();
    const std::string sentence = take_crash_sentence(number);
    if (!sentence.empty()) say(sentence);
    remove_guarded();
    _exit(exit_code_of_crashes);
  }

  void answer(int number) {
    std::unique_lock lock(mutex_);
    const auto over = [this] { return reached_ || !watching_; };
    if (changed_.wait_for(lock, grace_, over)) return;
    changed_.wait_for(lock, longest_replacing, [this] { return replacing_ == 0; });
    if (over()) return;
    tidy_up();  // with the lock, so that nothing more is begun
    say(sentence_);
    remove_guarded();
    _exit(exit_code_of_signals + number);
  }

  void tidy_up() {
    for (const int child : children_) {
      kill(-child, SIGKILL);  // it leads a group, its own children
      kill(child, SIGKILL);
    }
    const auto enough = std::chrono::steady_clock::now() + longest_dying;
    for (const int child : children_)
      while (waitpid(child, nullptr, WNOHANG) == 0 && std::chrono::steady_clock::now() < enough)
        std::this_thread::sleep_for(1ms);
    remove_guarded();
  }

  void say(const std::string& sentence) {
    char time[32] = "";
    const std::time_t now = std::time(nullptr);
    std::tm local{};
    if (localtime_r(&now, &local) != nullptr) std::strftime(time, sizeof time, "%Y-%m-%d %H:%M:%S ", &local);
    write_text(log_, time + sentence + "\n");
    const bool seen = said_to_ >= 0 && isatty(said_to_) != 0;
    write_text(said_to_, (seen ? "\r\x1b[2K\x1b[?25h" : "") + sentence + "\n");  // clear the bar, show the cursor
  }

  void remove_guarded() {
    for (const auto& [folder, prefix] : folders_)
      for (int sweep = 0; sweep < sweeps && !removed(folder, prefix); ++sweep) std::this_thread::sleep_for(1ms);
  }

  static bool removed(const files::path& folder, const std::string& prefix) {
    std::error_code error;
    bool all = true;
    files::directory_iterator entry(folder, error), end;
    while (!error && entry != end) {
      const files::path path = entry->path();
      entry.increment(error);
      if (path.filename().native().compare(0, prefix.size(), prefix) != 0) continue;
      std::error_code problem;
      files::remove_all(path, problem);
      all = all && !problem;
    }
    return all;
  }

  const pid_t process_ = getpid();
  std::mutex mutex_;
  std::condition_variable changed_;
  int pipe_[2] = {-1, -1};
  std::chrono::duration<double> grace_{0.0};
  std::string sentence_;
  std::set<std::pair<std::string, std::string>> folders_;  // and how the names begin of what to remove there
  std::set<int> children_;
  int said_to_ = -1;
  int log_ = -1;
  int replacing_ = 0;
  bool watching_ = false;
  bool reached_ = false;
};

Watch& watch() {
  static Watch* const only = new Watch;  // never deleted: its thread may outlive everything else
  return *only;
}

void watch_over_exit() { watch().end_at_exit(); }

// The lock may be held for good, by a thread that is ending the process.
template <class Work>
auto patiently(Work&& work) {
  const nanobind::gil_scoped_release release;
  return work();
}

int watch_signals(double grace, const std::string& sentence) {
  return patiently([&] { return watch().begin(grace, sentence); });
}
void stop_watching() {
  patiently([] { watch().end(); });
}
void acknowledge_signal() {
  patiently([] { watch().acknowledge(); });
}
void guard_folder(const nanobind::bytes& folder, const nanobind::bytes& prefix) {
  const std::string place(folder.c_str(), folder.size()), beginning(prefix.c_str(), prefix.size());
  patiently([&] { watch().guard_folder(place, beginning); });
}
void guard_process(int process, bool guarded) {
  patiently([&] { watch().guard_process(process, guarded); });
}
void guard_log(int descriptor) {
  patiently([&] { watch().guard_log(descriptor); });
}
void guard_replacing(bool begins) {
  patiently([&] { watch().replacing(begins); });
}
void sweep_guarded() {
  patiently([] { watch().sweep(); });
}
void tell_step(const nanobind::bytes& step) { crash_step(std::string(step.c_str(), step.size())); }

#else  // Windows: signals are Python's business alone

int watch_signals(double, const std::string&) { return -1; }
void stop_watching() {}
void acknowledge_signal() {}
void guard_folder(const nanobind::bytes&, const nanobind::bytes&) {}
void guard_process(int, bool) {}
void guard_log(int) {}
void guard_replacing(bool) {}
void sweep_guarded() {}
void tell_step(const nanobind::bytes&) {}

#endif

}  // namespace

void bind_interrupts(nanobind::module_& module) {
  using nanobind::arg;
  module.def("watch_signals", &watch_signals, arg("grace"), arg("sentence"));
  module.def("stop_watching", &stop_watching);
  module.def("acknowledge_signal", &acknowledge_signal);
  module.def("guard_folder", &guard_folder, arg("folder"), arg("prefix"));
  module.def("guard_process", &guard_process, arg("process"), arg("guarded"));
  module.def("guard_log", &guard_log, arg("descriptor"));
  module.def("guard_replacing", &guard_replacing, arg("begins"));
  module.def("sweep_guarded", &sweep_guarded);
  module.def("tell_step", &tell_step, arg("step"));
}

}  // namespace symrecon
