#include "src/synthetic/schedule.h"

#include <algorithm>
#include <cmath>

#include "src/base/names.h"
#include "src/synthetic/random.h"

namespace zygoma {
namespace {

constexpr const char* kJaw = "";

double minimum_jerk(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * x * (10.0 + x * (6.0 * x - 15.0));
}

// Times of one expression.
struct Beat {
  double start_s;
  double rise_s;
  double hold_s;
  double fall_s;
};

class Writer {
 public:
  Writer(Schedule& schedule, RandomStream& random) : schedule_(schedule), random_(random) {}

  // Both sides of a muscle, slightly unequal as in people.
  void both(const std::string& muscle, double level, const Beat& beat) {
    const double lean = random_.uniform(-0.06, 0.06);
    side(muscle + "_L", level + lean, beat);
    side(muscle + "_R", level - lean, beat);
  }

  void side(const std::string& muscle, double level, const Beat& beat) {
    schedule_.pulses.push_back(
        {muscle, std::clamp(level, 0.0, 1.0), beat.start_s, beat.rise_s, beat.hold_s, beat.fall_s});
  }

  void brow_raise(const Beat& beat) {
    const double level = random_.uniform(0.55, 0.8);
    both("occipitofrontalis_inner", level, beat);
    both("occipitofrontalis_major", level * random_.uniform(0.9, 1.1), beat);
    both("occipitofrontalis_outer", level * random_.uniform(0.8, 1.1), beat);
  }

  void smile(const Beat& beat) {
    const double level = random_.uniform(0.6, 0.85);
    const double lean = random_.uniform(-0.1, 0.1);
    side("zygomaticus_major_L", level + lean, beat);
    side("zygomaticus_major_R", level - lean, beat);
    both("levator_labii_superioris", 0.2, beat);
  }

  void frown(const Beat& beat) {
    both("corrugator_supercilii", random_.uniform(0.55, 0.8), beat);
    both("depressor_anguli_oris", random_.uniform(0.5, 0.75), beat);
  }

  void surprise(const Beat& beat) {
    const double level = random_.uniform(0.8, 0.95);
    both("occipitofrontalis_inner", level, beat);
    both("occipitofrontalis_major", level, beat);
    both("occipitofrontalis_outer", level, beat);
    side(kJaw, random_.uniform(0.5, 0.75), beat);
  }

  // Syllables: the jaw opens four times a second, the lips part and widen now and then.
  void speech(double start_s, double end_s) {
    double at = start_s;
    while (true) {
      const double length = random_.uniform(0.2, 0.34);
      if (at + length > end_s) break;
      const Beat beat{at, 0.45 * length, 0.1 * length, 0.45 * length};
      side(kJaw, random_.uniform(0.08, 0.3), beat);
      both("depressor_labii_inferioris", random_.uniform(0.0, 0.4), beat);
      both("levator_labii_superioris", random_.uniform(0.0, 0.25), beat);
      both("zygomaticus_major", random_.uniform(0.0, 0.2), beat);
      at += 0.8 * length;
    }
  }

 private:
  Schedule& schedule_;
  RandomStream& random_;
};

// Six seconds of everything, from `begin_s`, stretched to `length_s`.
void write_mixed_cycle(Writer& writer, double begin_s, double length_s) {
  const double unit = length_s / 6.0;
  const auto beat = [&](double start, double rise, double hold, double fall) {
    return Beat{begin_s + unit * start, unit * rise, unit * hold, unit * fall};
  };
  writer.brow_raise(beat(0.6, 0.35, 0.25, 0.35));
  writer.smile(beat(1.6, 0.4, 0.3, 0.4));
  writer.frown(beat(2.75, 0.4, 0.25, 0.35));
  writer.surprise(beat(3.75, 0.25, 0.3, 0.35));
  writer.speech(begin_s + unit * 4.7, begin_s + unit * 5.6);
}

}  // namespace

double Pulse::value_at(double time_s) const {
  const double up = minimum_jerk((time_s - start_s) / rise_s);
  const double down = minimum_jerk((time_s - start_s - rise_s - hold_s) / fall_s);
  return level * (up - down);
}

double Schedule::value_at(const std::string& muscle, double time_s) const {
  double sum = 0.0;
  for (const Pulse& pulse : pulses) {
    if (pulse.muscle == muscle) sum += pulse.value_at(time_s);
  }
  return std::clamp(sum, 0.0, 1.0);
}

const std::vector<std::string>& schedule_names() {
  static const std::vector<std::string> names{"mixed", "surprise", "smile", "speech", "neutral"};
  return names;
}

Schedule make_schedule(const std::string& name, double duration_s, std::uint32_t seed) {
  require_name("schedule", schedule_names(), name);
  Schedule schedule;
  if (name == "neutral") return schedule;
  RandomStream random(seed, 1);
  Writer writer(schedule, random);
  const double usual_s = name == "mixed" ? 6.0 : 3.0;
  const int cycles = std::max(1, static_cast<int>(std::lround(duration_s / usual_s)));
  const double length_s = duration_s / cycles;
  for (int i = 0; i < cycles; ++i) {
    const double begin_s = i * length_s;
    const double unit = length_s / usual_s;
    const Beat single{begin_s + 0.6 * unit, 0.35 * unit, 0.8 * unit, 0.5 * unit};
    if (name == "mixed") write_mixed_cycle(writer, begin_s, length_s);
    if (name == "surprise") writer.surprise(single);
    if (name == "smile") writer.smile(single);
    if (name == "speech") writer.speech(begin_s + 0.6 * unit, begin_s + 2.7 * unit);
  }
  return schedule;
}

}  // namespace zygoma
