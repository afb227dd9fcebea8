from robots.kit import former

former.install()
