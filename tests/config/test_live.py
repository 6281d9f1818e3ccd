"""Which keys change while the daemon runs, and how differences are named."""

from attest_mav.config.live import differences, with_live_keys
from attest_mav.config.parsing import parse_config

RUNNING = "[[link]]\nurl = 'udpin::1'\n"


def config(text=""):
    return parse_config(RUNNING + text, "test")


def reloaded(text):
    """The keys that change at once, and those that need a new start."""
    running, wanted = config(), parse_config(text, "test")
    live = with_live_keys(running, wanted)
    return list(differences(running, live)), list(differences(live, wanted))


def test_rates_thresholds_gains_outputs_and_the_log_change_at_once():
    text = (
        RUNNING + "publish = ['odometry']\nyield_to_stations = false\n"
        "[output]\nrate_hz = 5\nmax_sigma_deg = 2\n[verdict]\ntilt_deg = 4\nhold_s = 1\n"
        "[filter.velocity-aided]\nmag_delay_s = 0.1\n[filter.leveling]\ngravity = 9.8\n"
        "[log]\nlevel = 'debug'\nstatus_s = 1\n"
    )
    at_once, later = reloaded(text)
    assert later == []
    assert at_once == [
        "output.rate_hz",
        "output.max_sigma_deg",
        "link[0].publish",
        "link[0].yield_to_stations",
        "filter.leveling.gravity",
        "filter.velocity-aided.mag_delay_s",
        "verdict.tilt_deg",
        "verdict.hold_s",
        "log.level",
        "log.status_s",
    ]


def test_what_was_opened_asked_for_or_built_needs_a_new_start():
    at_once, later = reloaded(
        "[[link]]\nurl = 'udpin::2'\npublish = []\n[vehicle]\nsystem_id = 3\n[output]\ncomponent_id = 194\n"
        "[streams]\nimu_hz = 100\n[estimate]\nstale_s = 1\n[filter]\nname = 'leveling'\n"
        "[filter.leveling]\ngravity = 9.8\n"
    )
    assert at_once == []
    assert later == [
        "vehicle.system_id",
        "output.component_id",
        "link[0].url",
        "link[0].publish",
        "streams.imu_hz",
        "filter.name",
        "filter.leveling.gravity",
        "estimate.stale_s",
    ]


def test_a_filter_of_ones_own_needs_a_new_start():
    own = RUNNING + "[filter]\nname = 'own'\n[filter.own]\nclass = 'a:B'\n"
    running, wanted = parse_config(own, "test"), parse_config(own.replace("a:B", "a:C"), "test")
    assert with_live_keys(running, wanted) == running
    assert list(differences(running, wanted)) == ["filter.own.class"]


def test_a_link_more_needs_a_new_start():
    at_once, later = reloaded(RUNNING + "publish = []\n[[link]]\nurl = 'sim:'\n")
    assert at_once == []
    assert later[0] == "link[0].publish"
    assert later[1] == "link[1].url"


def test_values_are_shown_as_toml():
    found = differences(config(), config("[output]\nrate_hz = 5\n[verdict]\ntilt_deg = 4\n"))
    assert found == {"output.rate_hz": ("20.0", "5.0"), "verdict.tilt_deg": ('"auto"', "4.0")}
