"""The addresses of pages."""

from allauth.account import views as allauth
from django.contrib import admin
from django.contrib.auth.decorators import login_required
from django.templatetags.static import static
from django.urls import include, path
from django.views.generic import RedirectView

from accounts import confirm
from accounts import views as accounts
from operatorlog import results
from operatorlog import views as log
from portal.web.alerts import views as alerts
from portal.web.classic import pictures
from portal.web.classic import views as classic
from portal.web.composites import views as streams
from portal.web.daily import views as daily
from portal.web.feeds import views as feeds
from portal.web.jobs import views as jobs
from portal.web.pages import landing, practice, scripts, views
from portal.web.pages.choices import choose
from portal.web.pages.places import my_places
from portal.web.push import views as push
from portal.web.recordings import day, embeds, exports, oembed
from portal.web.recordings import views as recordings
from portal.web.statistics import views as statistics
from portal.web.translation import views as translation
from robots.once import once

urlpatterns = [
    path("", landing.landing, name="landing"),
    path("story/", views.story, name="story"),
    path("status/", views.status, name="status"),
    path("statistics/", daily.statistics, name="daily"),
    path("statistics.json", daily.statistics_json, name="daily-json"),
    path("statistics.csv", daily.statistics_csv, name="daily-csv"),
    path("language/", translation.choose, name="language"),
    path("texts/<str:language>/<slug:version>.js", translation.texts, name="texts"),
    path("me/", views.me, name="me"),
    path("me/alerts/", alerts.choose, name="alerts"),
    path("me/choices/", choose, name="choices"),
    path("me/places/", my_places, name="places"),
    path("me/push/", push.push, name="push"),
    path("push-worker.js", push.worker, name="push-worker"),
    path("robots/<slug:slug>/", views.robot_page, name="robot"),
    path("robots/<slug:slug>/drive/", landing.drive, name="drive"),
    path("robots/<slug:slug>/practise/", practice.practise, name="practise"),
    path("robots/<slug:slug>/model.urdf", views.model, name="model"),
    path("robots/<slug:slug>/stream-code/", scripts.stream_code, name="stream-code"),
    path("robots/<slug:slug>/programs/", scripts.programs_of, name="programs"),
    path("robots/<slug:slug>/orientation/", accounts.orientation, name="orientation"),
    path("robots/<slug:slug>/orientation/<slug:look>.webp", accounts.orientation_picture, name="orientation-picture"),
    path("robots/<slug:slug>/clearance/", accounts.clearance, name="clearance"),
    path("robots/<slug:slug>/jobs/", jobs.jobs_of, name="jobs"),
    path("robots/<slug:slug>/statistics/", statistics.statistics, name="statistics"),
    path("robots/<slug:slug>/statistics.json", statistics.statistics_json, name="statistics-json"),
    path("robots/<slug:slug>/live/<slug:name>.mjpg", streams.composite, name="composite"),
    path("robots/<slug:slug>/camera/<int:number>.mjpg", streams.camera, name="camera"),
    path("robots/<slug:slug>/camera/<int:number>.jpg", streams.snapshot, name="snapshot"),
    path("robots/<slug:slug>/camera/<int:number>/<int:at_ms>.jpg", streams.shot, name="shot"),
    path("jobs/<str:key>/", jobs.job_page, name="job"),
    path("robots/<slug:slug>/recordings/", recordings.recordings_of, name="recordings"),
    path("robots/<slug:slug>/time-lapse/", exports.ask_lapse, name="ask-lapse"),
    *(path(f"robots/<slug:slug>/time-lapse/<str:day>.{k}", exports.lapse, {"kind": k}) for k in exports.MEDIA),
    path("movie-of-the-day/", day.page, name="movie-of-the-day"),
    path("recordings/<str:key>/", recordings.replay, name="recording"),
    path("recordings/<str:key>/file.mcap", recordings.download, name="recording-file"),
    path("recordings/<str:key>/movie/", exports.ask_movie, name="ask-movie"),
    *(path(f"recordings/<str:key>/movie.{k}", exports.movie, {"kind": k}) for k in exports.MEDIA),
    path("recordings/<str:key>/<int:version>/index.json", recordings.index, name="recording-index"),
    path("recordings/<str:key>/<int:version>/<int:number>.bin", recordings.part, name="recording-part"),
    path("recordings/<str:key>/<int:version>/moment-<int:second>.jpg", embeds.picture, name="recording-picture"),
    path("embed/recordings/<str:key>/", embeds.recording, name="embed-recording"),
    path("embed/robots/<slug:slug>/", embeds.robot, name="embed-robot"),
    path("oembed/", oembed.oembed, name="oembed"),
    path("classic/<slug:slug>/", classic.enter, name="classic"),
    path("classic/<slug:slug>/<str:token>/", classic.page, name="classic-page"),
    path("classic/<slug:slug>/<str:name>.gif", pictures.picture, name="classic-picture"),
    path("log/", log.log, name="log"),
    path("log.atom", feeds.log, name="log-feed"),
    path("status.atom", feeds.status, name="status-feed"),
    path("robots/<slug:slug>/log.atom", feeds.log, name="robot-log-feed"),
    path("robots/<slug:slug>/status.atom", feeds.status, name="robot-status-feed"),
    path("robots/<slug:slug>/finds/", log.finds, name="finds"),
    path("robots/<slug:slug>/dug.json", log.dug, name="dug"),
    path("turns/<int:pk>/", log.turn_page, name="turn"),
    path("survey/results/", results.results, name="survey-results"),
    path("survey/results.csv", results.results_csv, name="survey-csv"),
    path("accounts/signup/", once(allauth.signup), name="account_signup"),
    path("accounts/email/", login_required(once(allauth.email)), name="account_email"),
    path("accounts/confirm-email/<str:key>/", confirm.ConfirmEmail.as_view(), name="account_confirm_email"),
    path("accounts/send-again/", confirm.send_again, name="send-again"),
    path("accounts/", include("allauth.account.urls")),
    path("admin/", admin.site.urls),
    path("media/frames/<path:path>", views.media, name="media"),
    path("favicon.ico", RedirectView.as_view(url=static("portal/icon.svg"))),
    path("livez", views.livez, name="livez"),
    path("readyz", views.readyz, name="readyz"),
]
handler404 = "portal.web.pages.errors.not_found"
handler403 = "portal.web.pages.errors.forbidden"
handler429 = "portal.web.pages.errors.too_many"  # allauth's
handler400 = "portal.web.pages.errors.bad_request"
handler500 = "portal.web.pages.errors.server_error"
