"""Show a tuning study, finished or still running, as one page without network.

`page.study_page` writes the page from a `review.StudyReview`; `follower.StudyFollower` follows a
study that another process writes; `gain_map.cost_map` draws the cost between the runs.
"""
